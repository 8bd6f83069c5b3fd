"""Whether somebody else publishes under our name: two vehicles with one id, as where a configuration was copied."""

import logging

import zenoh

from brake_monitor.publishing.zenoh_callback import AwaitedCallback
from brake_monitor.settings.key_space import KeySpace

ENOUGH = 3  # healths: one or two may be the last words of who published before us

log = logging.getLogger(__name__)


class Namesake:
    """Listens to health of our own wagon that is not ours, until there was enough of it."""

    def __init__(self, session: zenoh.Session, keys: KeySpace) -> None:
        self._wagon = keys.wagon
        self._heard = 0
        self._hearing = AwaitedCallback(self._hear)
        self._subscriber: zenoh.Subscriber[None] | None = session.declare_subscriber(
            keys.health, self._hearing.handler, allowed_origin=zenoh.Locality.REMOTE
        )

    def look(self) -> None:
        """Tell of it, once; nothing that others send is listened to from then on."""
        if self._heard >= ENOUGH and self._subscriber is not None:
            log.warning(
                "somebody else publishes as %s, too, and subscribers take the two for one: "
                "each vehicle needs a [vehicle] id of its own",
                self._wagon,
            )
            self.close()

    def close(self) -> None:
        """Listen no more."""
        if self._subscriber is not None:
            self._subscriber.undeclare()  # type: ignore[no-untyped-call]
            self._subscriber = None
            self._hearing.join()

    def _hear(self, _: zenoh.Sample) -> None:
        """Called in Zenoh's own thread: only count the message."""
        self._heard += 1
