"""The page's live connection, as its bytes."""

import json
import socket
from typing import Any

from program import PATIENCE_S

UPGRADE = {
    "Connection": "Upgrade",
    "Upgrade": "websocket",
    "Sec-WebSocket-Version": "13",
    "Sec-WebSocket-Key": "MDEyMzQ1Njc4OWFiY2RlZg==",
}


def first_words(port: int) -> dict[str, Any]:
    """The first message of a web socket."""
    with socket.create_connection(("127.0.0.1", port), timeout=PATIENCE_S) as browser:
        head = {"Host": f"127.0.0.1:{port}", "Origin": f"http://127.0.0.1:{port}"} | UPGRADE
        browser.sendall(
            b"GET /live HTTP/1.1\r\n" + b"".join(f"{k}: {v}\r\n".encode() for k, v in head.items()) + b"\r\n"
        )
        stream = browser.makefile("rb")
        while stream.readline() != b"\r\n":
            pass
        length = stream.read(2)[1] & 0x7F
        told: dict[str, Any] = json.loads(
            stream.read(int.from_bytes(stream.read(2), "big") if length == 126 else length)
        )
        return told
