"""The server of `frictionlab app`: pages of models and Voila, on this machine, for whoever has the link.

The pages of models hold the solver and need no kernel; the explorer whose engine is Python has one of a few.

Voila and jupyter-server have tokens, cookies, the check of a request's origin, and an end for idle kernels.
This module puts them together.  The channels of kernels are files of this user, not ports.  The token is
compared in constant time, exchanged for a cookie and taken out of the address.  Requests that name another
host are refused, and the number of kernels is limited.
"""

from __future__ import annotations

import asyncio
import contextlib
import hmac
import os
import socket
import threading
import webbrowser
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from tempfile import gettempdir
from typing import Any
from urllib.parse import urlencode
from uuid import UUID

from jupyter_server.auth.identity import IdentityProvider
from jupyter_server.base.call_context import CallContext
from jupyter_server.base.handlers import JupyterHandler
from jupyter_server.services.kernels.handlers import KernelActionHandler
from jupyter_server.services.kernels.kernelmanager import AsyncMappingKernelManager
from jupyter_server.utils import url_path_join
from tornado import web
from tornado.httpserver import HTTPServer
from tornado.ioloop import IOLoop
from traitlets import Instance, List
from traitlets.config import Config
from voila.app import Voila
from voila.tornado.handler import TornadoVoilaHandler

# The names of this machine in requests of its own browsers; no others are served.  Another site can give its
# own name this machine's address (DNS rebinding), and the browser would take the explorer for a part of it.
LOCAL_HOSTS = r"(localhost|127\.0\.0\.1|\[::1\])$"
MAX_KERNELS = 4  # explorers at once; a kernel takes some 310 MB
IDLE_TIME = 120  # s that a kernel without its page is kept: the network may pause, a laptop may be closed
IDLE_CHECK = 20  # s between two searches for such kernels
SOCKET_PATH = 104  # bytes of a socket's path, with the zero at its end; the least that systems allow
SOCKET_NAME = f"voila_12345678/kernel-{UUID(int=0)}-ipc-1"  # as long as those that there will be
LINK_NEEDED = "The explorer needs the whole link that frictionlab app printed, with its token"
TOO_MANY = f"{MAX_KERNELS} explorers are open: close one of their pages, then reload this one"
INTERRUPTS = r"/api/kernels/(?P<kernel_id>[\w-]+)/(?P<action>interrupt)"
MODELS = "models"  # where the pages are that need no kernel
# Voila's page requests an optional style sheet from another server, and stays blank until that answers
# or fails: with that request forbidden the page appears at once, also without a network.
CONTENT_SECURITY_POLICY = (
    "default-src 'self' ws: data: blob: 'unsafe-inline' 'unsafe-eval'; frame-ancestors 'self'"
)
# A browser sends such a cookie when a page of this server is opened, wherever the link was, but not with what
# a page of another site loads or sends.
SAME_SITE = {"samesite": "Lax"}


class LinkIdentity(IdentityProvider):
    """Admits whoever brings the link's token, and from then on the cookie; refuses all others."""

    async def get_user(self, handler: Any) -> Any:
        user_of_request: Any = super().get_user(handler)
        user = await user_of_request
        if user is None:
            handler.current_user = None  # the error page reads it
            raise web.HTTPError(403, reason=LINK_NEEDED)
        return user

    async def get_user_token(self, handler: Any) -> Any:
        """The user who gave the token; the time of comparing does not tell how much of it was right."""
        token = self.get_token(handler) or ""
        if not hmac.compare_digest(token.encode(), str(self.token).encode()):
            return None
        return self.get_user_cookie(handler) or self.generate_anonymous_user(handler)

    def is_token_authenticated(self, handler: Any) -> bool:
        """Never, so that origins are always checked: other sites' pages may not call even with the token."""
        return False

    def get_handlers(self) -> list[Any]:
        """No pages for logging in: the link does that."""
        return []


class PageKernels(AsyncMappingKernelManager):
    """A kernel for each explorer that is open; idle kernels whose pages are gone are ended.

    A page that is reloaded leaves its kernel behind before it asks for the next one, so kernels of the same
    browser that have no page any more are ended first.  At most `MAX_KERNELS` run at once.
    """

    def __init__(self, **options: Any) -> None:
        super().__init__(cull_idle_timeout=IDLE_TIME, cull_interval=IDLE_CHECK, **options)
        self._page_of: dict[str, ExplorerPage] = {}  # the page that a kernel was started for
        self._one_at_a_time = asyncio.Lock()  # no other kernel is started between the count and the start

    async def start_kernel(self, **options: Any) -> str:
        page: ExplorerPage = CallContext.get(CallContext.JUPYTER_HANDLER)
        async with self._one_at_a_time:
            await self._make_room(page.browser)
            kernel_id = await super().start_kernel(**options)
            self._page_of[kernel_id] = page
        return kernel_id

    async def _make_room(self, browser: str) -> None:
        connections = {about["id"]: about["connections"] for about in self.list_kernels()}
        self._page_of = {name: page for name, page in self._page_of.items() if name in connections}
        in_use = [name for name, page in self._page_of.items() if connections[name] or not page.is_sent]
        without_page = [name for name in connections if name not in in_use]
        for kernel_id in without_page:
            if kernel_id not in self._page_of or self._page_of[kernel_id].browser == browser:
                await self._end(kernel_id)
        for kernel_id in without_page:  # the oldest first
            if len(self) >= MAX_KERNELS:
                await self._end(kernel_id)
        if len(self) >= MAX_KERNELS:
            raise web.HTTPError(503, reason=TOO_MANY)

    async def _end(self, kernel_id: str) -> None:
        # Its page may have ended it meanwhile, while closing.
        with contextlib.suppress(web.HTTPError, KeyError):
            await self.shutdown_kernel(kernel_id, now=True)


def is_redirected(handler: JupyterHandler) -> bool:
    """Whether the browser is sent to the same address without the token.  Other sites are refused."""
    if not handler.check_origin():
        raise web.HTTPError(403)
    others = {k: v for k, v in handler.request.query_arguments.items() if k != "token"}
    if "token" in handler.request.query_arguments:
        handler.redirect(handler.request.path + (f"?{urlencode(others, doseq=True)}" if others else ""))
    return "token" in handler.request.query_arguments


class ExplorerPage(TornadoVoilaHandler):
    """The explorer's page, without the token in its address, where others might read it from the screen."""

    is_sent = False  # until then its kernel is in use, though nobody has connected to it yet

    @property
    def browser(self) -> str:
        """The browser that sent the request, by the user name in its cookie."""
        return self.current_user.username

    def on_finish(self) -> None:
        self.is_sent = True
        super().on_finish()

    def on_connection_close(self) -> None:
        """The browser no longer waits for the page: it was closed or reloaded."""
        self.is_sent = True
        super().on_connection_close()

    async def get(self, path: str | None = None) -> None:
        if is_redirected(self):
            return
        self.xsrf_token  # noqa: B018  # reading it sets the cookie with which a page that closes ends its kernel
        sent: Any = super().get(path=path)
        await sent


class ModelPages:
    """The pages of `frictionlab page --all` in a folder, each written when it is first asked for."""

    def __init__(self, folder: Path) -> None:
        self.folder, self.thread = folder, ThreadPoolExecutor(1)  # sympy derives for one at a time

    def content(self, name: str) -> bytes | None:
        """The page of this file name; None where there is none."""
        from frictionlab.pages import gallery

        scenes = gallery.library_scenes()
        if name in ("", gallery.INDEX):
            return gallery.index_page(scenes, {}, explorer="../").encode()
        scene = next((each for each in scenes if each.file == name), None)
        if scene is None:
            return None
        path = self.folder / name
        if not path.exists():
            gallery.write_scene(scene, path, gallery.scene_labels(scenes))
        return path.read_bytes()


class ModelPage(JupyterHandler):
    """A page of a model, with the solver in it, or their index: no kernel computes what it shows."""

    def initialize(self, pages: ModelPages) -> None:
        self.pages = pages

    @web.authenticated
    async def get(self, name: str) -> None:
        """Send the page; it is written when it is first asked for."""
        if is_redirected(self):
            return
        loop = asyncio.get_running_loop()
        content = await loop.run_in_executor(self.pages.thread, self.pages.content, name)
        if content is None:
            raise web.HTTPError(404)
        self.set_header("Content-Type", "text/html; charset=utf-8")
        self.finish(content)


class ExplorerServer(Voila):
    """Voila with the kernels, page and identity of this module, and sockets that were opened before."""

    sockets = List(Instance(socket.socket))
    pages = Instance(ModelPages)

    def init_handlers(self) -> list[Any]:
        """Add handlers for this machine's own names; return one that refuses requests to any other."""
        handlers: Any = super().init_handlers()
        own = [(pattern, _page(handler), *rest) for pattern, handler, *rest in handlers]
        own.insert(0, (url_path_join(self.base_url, rf"/{MODELS}/(.*)"), ModelPage, {"pages": self.pages}))
        own.insert(0, (url_path_join(self.base_url, INTERRUPTS), KernelActionHandler))  # the button "stop"
        self.app.add_handlers(LOCAL_HOSTS, own)
        return [(r".*", web.ErrorHandler, {"status_code": 403})]

    def listen(self) -> None:
        """Serve at the sockets that listen already; Voila would open a port of its own."""
        HTTPServer(self.app).add_sockets(self.sockets)
        if self.open_browser:
            self.launch_browser()
        self.ioloop = IOLoop.current()
        try:
            self.ioloop.start()
        finally:
            self.stop()

    def launch_browser(self) -> None:
        """Open the link through a file beside the notebook: all users could read a command's arguments."""
        link = f"{self.connection_url}{MODELS}/?token={self.token}"
        page = Path(str(self.notebook_path)).with_name("open.html")
        page.write_text(f'<meta http-equiv="refresh" content="0; url={link}">', encoding="utf-8")
        threading.Thread(target=webbrowser.open, args=(page.as_uri(),), daemon=True).start()


def _page(handler: Any) -> Any:
    return ExplorerPage if handler is TornadoVoilaHandler else handler


def kernel_sockets(folder: str, system: str = os.name) -> dict[str, dict[str, str]]:
    """Settings by which the server speaks to kernels through files of this user alone, not through ports.

    Ports of this machine are open to all its users.  Windows has no such files; where the path of the
    temporary folder is too long for them, they are in /tmp, in a folder of this user's too.
    """
    if system == "nt":
        return {}
    root = folder if len(os.path.join(folder, SOCKET_NAME).encode()) < SOCKET_PATH else "/tmp"
    return {"KernelManager": {"transport": "ipc"}, "Voila": {"connection_dir_root": root}}


def serve(notebook: Path, sockets: list[socket.socket], token: str, browser: bool) -> None:
    """Serve the notebook's page until the loop is stopped."""
    config = Config(
        {
            "VoilaConfiguration": {"show_tracebacks": True, "multi_kernel_manager_class": PageKernels},
            "LinkIdentity": {"cookie_options": SAME_SITE},
            **kernel_sockets(gettempdir()),
        }
    )
    ExplorerServer.launch_instance(
        [str(notebook)],
        config=config,
        config_file_paths=[],  # otherwise a file voila.py in the current folder would be run
        log_level="ERROR",
        port=sockets[0].getsockname()[1],
        sockets=sockets,
        pages=ModelPages(notebook.parent),
        token=token,
        open_browser=browser,
        identity_provider_class=LinkIdentity,
        tornado_settings={
            "headers": {"Content-Security-Policy": CONTENT_SECURITY_POLICY},
            "xsrf_cookie_kwargs": SAME_SITE,
        },
    )
