"""What the kernel knows of a CAN interface, asked over rtnetlink(7): whether its controller is able to send at all.

Asking is reading: RTM_GETLINK changes nothing and needs no capability.
"""

import errno
import os
import socket
import struct
from typing import NamedTuple

_NLMSG = struct.Struct("=IHHII")  # nlmsghdr: length, type, flags, sequence, port
_IFINFO = struct.Struct("=BxHiII")  # ifinfomsg: family, device type, index, flags, change
_ATTRIBUTE = struct.Struct("=HH")  # nlattr: length with this header, type; each begins at a multiple of 4
_CTRLMODE = struct.Struct("=II")  # can_ctrlmode: mask, flags
_ERROR = struct.Struct("=i")  # nlmsgerr: minus errno

_NLMSG_ERROR, _RTM_NEWLINK, _RTM_GETLINK, _NLM_F_REQUEST = 2, 16, 18, 1
_IFLA_IFNAME, _IFLA_LINKINFO = 3, 18
_LONGEST_NAME = 15  # IFNAMSIZ less its end
_IFLA_INFO_KIND, _IFLA_INFO_DATA = 1, 2
_IFLA_CAN_CTRLMODE = 5
_CAN_CTRLMODE_LISTENONLY = 0x02
_ARPHRD_CAN = 280
_IFF_UP = 1
_TYPE_MASK = 0x3FFF  # the two highest bits of an attribute's type are flags
_ANSWER_BYTES = 1 << 16
_PATIENCE_S = 2.0

_WITHOUT_A_CONTROLLER = {"vcan", "vxcan"}


class CanLink(NamedTuple):
    """A network interface as rtnetlink describes it."""

    is_can: bool
    kind: str  # "can" with a controller's driver, "vcan", "vxcan"; "" when the driver does not say
    listen_only: bool  # the controller neither sends frames nor acknowledges them
    is_up: bool

    @property
    def cannot_disturb(self) -> bool:
        """Whether nothing that this machine does can reach a wire."""
        return self.kind in _WITHOUT_A_CONTROLLER or self.listen_only


def read_link(name: str) -> CanLink:
    """Ask the kernel for the interface; OSError when there is none (ENODEV) or it does not answer."""
    if not name or len(os.fsencode(name)) > _LONGEST_NAME:
        raise OSError(errno.ENODEV, os.strerror(errno.ENODEV))
    body = _IFINFO.pack(socket.AF_UNSPEC, 0, 0, 0, 0) + _attribute(_IFLA_IFNAME, os.fsencode(name) + b"\0")
    request = _NLMSG.pack(_NLMSG.size + len(body), _RTM_GETLINK, _NLM_F_REQUEST, 1, 0) + body
    with socket.socket(socket.AF_NETLINK, socket.SOCK_RAW | socket.SOCK_CLOEXEC, socket.NETLINK_ROUTE) as asking:
        asking.settimeout(_PATIENCE_S)
        asking.sendto(request, (0, 0))
        return parse_link(asking.recv(_ANSWER_BYTES))


def _attribute(kind: int, content: bytes) -> bytes:
    length = _ATTRIBUTE.size + len(content)
    return _ATTRIBUTE.pack(length, kind) + content + bytes(-length % 4)


def parse_link(answer: bytes) -> CanLink:
    """The interface in an answer to RTM_GETLINK; OSError when the answer is an error or none at all."""
    try:
        length, kind, *_ = _NLMSG.unpack_from(answer)
        if kind == _NLMSG_ERROR:
            (error,) = _ERROR.unpack_from(answer, _NLMSG.size)
            raise OSError(-error, os.strerror(-error))
        if kind != _RTM_NEWLINK or length > len(answer):
            raise OSError(errno.EBADMSG, "the kernel's answer is not understood")
        _, device_type, _, state, _ = _IFINFO.unpack_from(answer, _NLMSG.size)
        link = _attributes(answer[_NLMSG.size + _IFINFO.size : length])
        info = _attributes(link.get(_IFLA_LINKINFO, b""))
        controller = _attributes(info.get(_IFLA_INFO_DATA, b""))
        mode = controller.get(_IFLA_CAN_CTRLMODE)
        flags = _CTRLMODE.unpack_from(mode)[1] if mode is not None else 0
    except struct.error:
        raise OSError(errno.EBADMSG, "the kernel's answer is not understood") from None
    name = info.get(_IFLA_INFO_KIND, b"").rstrip(b"\0").decode("ascii", "replace")
    listen_only = name == "can" and bool(flags & _CAN_CTRLMODE_LISTENONLY)
    return CanLink(device_type == _ARPHRD_CAN, name, listen_only, bool(state & _IFF_UP))


def _attributes(content: bytes) -> dict[int, bytes]:
    """Attributes by type; struct.error when their lengths make no sense."""
    found = {}
    place = 0
    while place + _ATTRIBUTE.size <= len(content):
        length, kind = _ATTRIBUTE.unpack_from(content, place)
        if not _ATTRIBUTE.size <= length <= len(content) - place:
            raise struct.error
        found[kind & _TYPE_MASK] = content[place + _ATTRIBUTE.size : place + length]
        place += (length + 3) & ~3
    return found
