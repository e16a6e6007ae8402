"""The server of `frictionlab app`: whom it lets in, from where, and how many kernels it starts."""

import asyncio
import os
import re
import subprocess
import sys
import time
from http.client import HTTPConnection
from pathlib import Path
from urllib.parse import urlsplit

import pytest

pytest.importorskip("voila", reason="voila serves the page; it is not installed")
psutil = pytest.importorskip("psutil", reason="it counts kernels, and comes with ipykernel")

from tornado.httpclient import HTTPClientError, HTTPRequest  # noqa: E402  after the check that tornado is there
from tornado.websocket import websocket_connect  # noqa: E402  as above

from frictionlab.cli import app_server  # noqa: E402  it needs tornado

ROOT = Path(__file__).parents[3]
PATIENCE = 120  # seconds
# The command, with as many kernels and as little patience as a test has time for, and an empty page, as the
# explorer takes some seconds.
SERVER = """
from frictionlab.cli import app, app_server, command
app.NOTEBOOK_CELL = "0"
app_server.MAX_KERNELS, app_server.IDLE_TIME, app_server.IDLE_CHECK = {most}, {idle}, 1
raise SystemExit(command.main(["app", "--no-browser"]))
"""


class App:
    """A running `frictionlab app`, in a folder where somebody left a configuration that would end it."""

    def __init__(self, folder, most, idle):
        (folder / "voila.py").write_text("raise SystemExit(3)")
        (folder / "voila.json").write_text('{"Voila": {"token": ""}}')
        command = [sys.executable, "-P", "-c", SERVER.format(most=most, idle=idle)]  # as `frictionlab` does
        variables = os.environ | {"PYTHONPATH": str(ROOT)}
        pipe = subprocess.PIPE
        self.process = subprocess.Popen(command, cwd=folder, env=variables, stdout=pipe, text=True)
        self.link = re.search(r"http\S+", self.process.stdout.readline())[0]
        address = urlsplit(self.link)
        self.host, self.first = address.netloc, f"{address.path}?{address.query}"
        self._wait()

    def _wait(self):
        for _ in range(5 * PATIENCE):
            try:
                return self.get("/static/nothing")
            except OSError:
                time.sleep(0.2)
        raise AssertionError("the server does not answer")

    def get(self, path, cookies="", host=None, method="GET", **headers):
        """Status, headers and text of an answer."""
        connection = HTTPConnection(self.host, timeout=PATIENCE)
        connection.request(method, path, headers={"Host": host or self.host, "Cookie": cookies, **headers})
        answer = connection.getresponse()
        text = answer.read().decode(errors="replace")
        connection.close()
        return answer.status, answer.headers, text

    def enter(self):
        """The cookies of one more browser that opened the link."""
        status, headers, _ = self.get(self.first)
        assert (status, headers["Location"]) == (302, "/")
        return cookies_in(headers)

    def page(self, cookies):
        """The id of the kernel of a page, and the cookie by which the page may end it."""
        status, headers, text = self.get("/", cookies)
        assert status == 200
        return re.search(r'"kernelId": "([^"]+)"', text)[1], f"{cookies}; {cookies_in(headers)}"

    def kernels(self):
        """How many run."""
        return len(self.kernel_processes())

    def wait_for_kernels(self, number):
        end = time.monotonic() + PATIENCE
        while self.kernels() != number and time.monotonic() < end:
            time.sleep(0.2)
        assert self.kernels() == number

    def connect(self, kernel_id, cookies, origin):
        """A socket to a kernel; to be called in a loop of asyncio."""
        address = f"ws://{self.host}/api/kernels/{kernel_id}/channels"
        headers = {"Cookie": cookies, "Origin": origin}
        return websocket_connect(HTTPRequest(address, headers=headers, request_timeout=PATIENCE))

    def end(self):
        self.process.terminate()
        self.process.communicate(timeout=PATIENCE)

    def kernel_processes(self):
        children = psutil.Process(self.process.pid).children(recursive=True)
        return [child for child in children if "ipykernel_launcher" in " ".join(command_line(child))]


def cookies_in(headers):
    return "; ".join(line.partition(";")[0] for line in headers.get_all("Set-Cookie"))


async def close(socket):
    """Close a socket and wait until the server has heard of it."""
    socket.close()
    while await socket.read_message() is not None:
        pass


def command_line(process):
    try:
        return process.cmdline()
    except psutil.Error:  # it ended in the meantime
        return []


@pytest.fixture(scope="module")
def app(tmp_path_factory):
    served = App(tmp_path_factory.mktemp("app"), most=2, idle=1000)
    yield served
    served.end()


@pytest.fixture(scope="module")
def visitor(app):
    """Cookies of a browser with a page, and its kernel."""
    cookies = app.enter()
    kernel_id, cookies = app.page(cookies)
    return cookies, kernel_id


@pytest.mark.parametrize(
    "path", ["/", "/?token=", "/?token=wrong", "/?token=%FF", "/login", "/voila/files/explorer.ipynb"]
)
def test_without_the_token_there_is_nothing_to_see(app, path):
    status, headers, text = app.get(path)
    assert status in (400, 403)
    assert "kernelId" not in text
    assert "Location" not in headers


@pytest.mark.skipif(os.name == "nt", reason="kernels have ports on Windows")
def test_the_channels_of_kernels_have_no_ports(app, visitor):
    """Other users of the machine could knock there; the files they listen at are in a folder of this user.

    ipykernel has one port of its own, for what its child processes print.
    """
    for process in app.kernel_processes():
        sockets = process.net_connections("all")
        listening = [each for each in sockets if each.status == psutil.CONN_LISTEN]
        assert len(listening) <= 1
        folders = {Path(each.laddr).parent for each in sockets if "-ipc-" in str(each.laddr)}
        assert len(folders) == 1
        assert folders.pop().stat().st_mode & 0o077 == 0


@pytest.mark.parametrize(("folder", "root"), [("/tmp", "/tmp"), ("/var/folders/" + "x" * 40, "/tmp")])
def test_the_path_of_a_kernels_sockets_is_not_too_long(folder, root):
    found = app_server.kernel_sockets(folder, "posix")
    assert found["Voila"] == {"connection_dir_root": root}
    assert app_server.kernel_sockets(folder, "nt") == {}


@pytest.mark.parametrize("host", ["evil.example", "localhost.evil.example", "192.168.0.1", ""])
def test_another_host_is_refused_even_with_the_token(app, visitor, host):
    cookies, kernel_id = visitor
    host = f"{host}:{app.host.rpartition(':')[2]}"
    for path in (app.first, "/", f"/api/kernels/{kernel_id}", "/voila/static/voila.js"):
        assert app.get(path, cookies, host=host)[0] in (400, 403)


def test_a_page_of_another_site_is_refused_even_with_the_token(app, visitor):
    before = app.kernels()
    for path in (app.first, "/", f"/api/kernels/{visitor[1]}"):
        assert app.get(path, visitor[0], Origin="http://evil.example")[0] in (403, 404)
    assert app.kernels() == before


def test_the_token_is_given_up_for_a_cookie_that_others_do_not_get(app):
    _, headers, _ = app.get(app.first)
    (cookie,) = headers.get_all("Set-Cookie")
    assert cookie.startswith("username-")
    assert {"HttpOnly", "SameSite=Lax"} <= set(cookie.split("; "))
    assert app.link.partition("token=")[2] not in cookie
    assert app.get("/api/kernels/none", cookie.partition(";")[0].replace("2|1", "2|2"))[0] == 403


def test_a_socket_opens_for_the_page_alone(app, visitor):
    cookies, kernel_id = visitor
    own, others = f"http://{app.host}", "http://evil.example"

    async def status(cookies, origin):
        try:
            socket = await app.connect(kernel_id, cookies, origin)
        except HTTPClientError as error:
            return error.code
        await close(socket)
        return 101

    assert asyncio.run(status(cookies, own)) == 101
    assert asyncio.run(status(cookies, others)) == 403
    assert asyncio.run(status("", own)) == 403


def test_a_page_that_is_loaded_again_has_one_kernel(app):
    cookies = app.enter()
    before = app.kernels()
    kernels = [app.page(cookies)[0] for _ in range(3)]
    assert len(set(kernels)) == 3
    assert app.kernels() <= before + 1


def test_a_page_that_closes_ends_its_kernel(app):
    kernel_id, cookies = app.page(app.enter())
    before = app.kernels()
    _, _, xsrf = cookies.partition("_xsrf=")
    path = f"/voila/api/shutdown/{kernel_id}"
    assert app.get(path, cookies, method="POST")[0] == 403
    assert app.get(f"{path}?_xsrf={xsrf}", cookies, method="POST")[0] == 204
    app.wait_for_kernels(before - 1)


def test_no_more_pages_than_allowed_have_a_kernel(app):
    """Those that nobody looks at make room; where all are looked at, the next is told so."""

    async def look():
        sockets = []
        for _ in range(2):
            kernel_id, cookies = await asyncio.to_thread(lambda: app.page(app.enter()))
            sockets.append(await app.connect(kernel_id, cookies, f"http://{app.host}"))
        refused = await asyncio.to_thread(app.get, "/", app.enter())
        await close(sockets[0])
        allowed = await asyncio.to_thread(app.get, "/", app.enter())
        await close(sockets[1])
        return refused, allowed

    (status, _, text), (then, _, _) = asyncio.run(look())
    assert status == 503
    assert "close one of their pages" in text
    assert then == 200
    assert app.kernels() == 2


def test_a_kernel_without_a_page_is_ended_after_a_while(tmp_path):
    app = App(tmp_path, most=2, idle=2)
    try:
        app.page(app.enter())
        app.wait_for_kernels(0)
    finally:
        app.end()
