"""Whether anybody answers at the endpoints that we connect to: a wrong address looks like a router that is gone."""

import logging
from collections.abc import Sequence

import zenoh

from brake_monitor.publishing.zenoh_endpoints import shown

LOOKS = 3  # in a row without anybody; connecting takes some time

log = logging.getLogger(__name__)


class Neighbour:
    """A router, or whoever else may be connected to; it may come and go."""

    def __init__(self, session: zenoh.Session, endpoints: Sequence[str]) -> None:
        self._session = session
        self._endpoints = endpoints
        self._missed = 0

    def look(self) -> None:
        """Tell when nobody answers, once, and when somebody does again."""
        if not self._endpoints:
            return
        if self._session.info.routers_zid() or self._session.info.peers_zid():
            if self._missed >= LOOKS:
                log.info("connected to a Zenoh router")
            self._missed = 0
            return
        self._missed += 1
        if self._missed == LOOKS:
            log.warning("no Zenoh router answers at %s; still trying", " or ".join(map(shown, self._endpoints)))
