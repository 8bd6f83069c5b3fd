"""Who may look, and what a browser is told to be careful with. The page needs nothing from elsewhere."""

from ipaddress import ip_address
from urllib.parse import urlsplit

from aiohttp import web
from aiohttp.typedefs import Handler, Middleware

HEADERS = {
    "Content-Security-Policy": "default-src 'none'; script-src 'self'; style-src 'self'; connect-src 'self'; "
    "img-src 'self'; base-uri 'none'; form-action 'none'; frame-ancestors 'none'",
    "X-Content-Type-Options": "nosniff",
    "Referrer-Policy": "no-referrer",
    "Cross-Origin-Opener-Policy": "same-origin",
    "Cross-Origin-Resource-Policy": "same-origin",
    "Cache-Control": "no-cache",
}


def is_known_host(host: str, names: frozenset[str]) -> bool:
    """Whether a Host header names us: an IP address, or one of the names.

    A page of somebody else whose name was made to resolve to our address (DNS rebinding) comes with that name.
    """
    try:
        name = urlsplit(f"//{host}").hostname or ""
    except ValueError:
        return False
    if name in names:
        return True
    try:
        ip_address(name.partition("%")[0])
    except ValueError:
        return False
    return True


def is_own_page(request: web.Request) -> bool:
    """Whether a web socket is asked for by our own page; a browser always says whose page asks."""
    origin = request.headers.get("Origin")
    try:
        return origin is not None and urlsplit(origin).netloc == request.host
    except ValueError:
        return False


def careful(names: frozenset[str]) -> Middleware:
    """Turn away requests under a foreign name, and give every answer the headers that keep a browser careful."""

    @web.middleware
    async def handle(request: web.Request, handler: Handler) -> web.StreamResponse:
        if not is_known_host(request.host, names):
            raise web.HTTPMisdirectedRequest(text="This name is not ours; see --name.\n", headers=HEADERS)
        try:
            response = await handler(request)
        except web.HTTPException as refusal:
            refusal.headers.update(HEADERS)
            raise
        if not response.prepared:
            response.headers.update(HEADERS)
        return response

    return handle
