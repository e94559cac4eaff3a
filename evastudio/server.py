"""The front door: the page, the API and the 3D views behind one port and one origin."""

from __future__ import annotations

import asyncio
import contextlib
import gc
import os
import signal
import socket
import subprocess
import sys
import threading
import time
import webbrowser
from collections.abc import AsyncIterator, Callable
from concurrent.futures import ThreadPoolExecutor
from dataclasses import replace

import uvicorn
from fastapi import FastAPI, Request, WebSocket
from starlette.responses import FileResponse, Response
from starlette.staticfiles import StaticFiles
from starlette.types import ASGIApp

from evastudio.api import limits, openapi, problems
from evastudio.api.access import Guard
from evastudio.api.app import PREFIX, add_routes
from evastudio.api.context import Context
from evastudio.api.door import Door
from evastudio.api.people import People, Visitor
from evastudio.api.repeats import Repeats
from evastudio.api.wire import PatientProtocol
from evastudio.demonstrations.store import Store
from evastudio.errors import InvalidInputError, NotFoundError
from evastudio.live.jobs import Job, Jobs
from evastudio.live.signed_in import earlier_runs
from evastudio.live.stages import Stages
from evastudio.live.tokens import Role, Tokens, cookie_of, digest
from evastudio.observing.health import Health
from evastudio.observing.metrics import CONTENT_TYPE, Metrics
from evastudio.observing.requests import Requests
from evastudio.observing.store_times import watch_store
from evastudio.settings import Settings
from evastudio.studio.client import client_page
from evastudio.studio.filming import film
from evastudio.studio.scheme import Scheme
from evastudio.studio.views import Views
from evastudio.workspace import shipped
from evastudio.world.compiled import is_compiled, load

GRACE_S = 1
"""So long requests that run have to end when the studio does; with what follows it ends in 5 s."""
LEAVE_S = 0.5
"""So long the process has to end by itself once everything is saved."""
BACKLOG = 128
"""Connections that may wait while the studio starts."""


def create_app(settings: Settings, port: int) -> FastAPI:
    """The whole studio as an ASGI application that will be reached at `port`.

    Raises StorageError where the workspace or its store cannot be used.
    """
    workspace = replace(settings.workspace, paths=False).ready()
    store = Store(workspace.store_url)
    views = Views()
    metrics = Metrics()
    watch_store(store.engine, metrics.store_took)

    @contextlib.asynccontextmanager
    async def lifespan(app: FastAPI) -> AsyncIterator[None]:
        loop = asyncio.get_running_loop()
        context: Context

        def job_changed(job: Job) -> None:
            metrics.job_changed(job)
            with contextlib.suppress(RuntimeError):  # the loop is closing
                loop.call_soon_threadsafe(tell_job, job)

        def tell_job(job: Job) -> None:
            for listener in list(context.job_listeners):
                listener(job)

        context = Context(workspace, store, Jobs(job_changed), Stages(workspace, store), film)
        context.stage_closed.append(views.close)
        app.state.context = context
        metrics.look_at(context.stages, context.jobs, lambda: context.messages_waiting)
        compiler = None
        if not is_compiled():
            compiler = subprocess.Popen([sys.executable, "-m", "evastudio.learning.kernels.warm"])
        app.state.views = views
        yield
        if compiler is not None:
            compiler.kill()
        # On a thread of its own: those of the loop may all be waiting for a store that is locked.
        with ThreadPoolExecutor(1, "closing") as closing:
            await loop.run_in_executor(closing, context.stages.close_all)
            views.close_all()
            await loop.run_in_executor(closing, context.lineups.close_all)
            await loop.run_in_executor(closing, context.worlds.close_all)
            await loop.run_in_executor(closing, context.jobs.close)
            if compiler is not None:
                await loop.run_in_executor(closing, compiler.wait)
        store.close()

    app = _App(
        title="EVA Studio",
        lifespan=lifespan,
        docs_url=None,
        redoc_url=None,
        openapi_url=f"{PREFIX}/openapi.json",
        generate_unique_id_function=lambda route: route.name,
        max_body_size=limits.MOST_BODY_BYTES,
    )
    problems.install(app)
    add_routes(app)
    openapi.describe(app)
    web = shipped() / "web"

    @app.get("/", include_in_schema=False)
    async def page(visitor: Visitor) -> Response:
        author = visitor.role is Role.AUTHOR
        return FileResponse(web / ("index.html" if author else "watch.html"))

    @app.get("/compare", include_in_schema=False)
    async def compare_page() -> Response:
        return FileResponse(web / "compare.html")

    @app.get("/vote", include_in_schema=False)
    async def vote_page() -> Response:
        return FileResponse(web / "vote.html")

    @app.get("/view/{stage}/", include_in_schema=False)
    @app.get("/view/{stage}/{scheme}/", include_in_schema=False)
    async def view_page(stage: str, request: Request, scheme: Scheme | None = None) -> Response:
        if request.app.state.context.lineups.column(stage) is None:
            request.app.state.context.stages.get(stage)
        client = client_page(scheme)
        headers = {"ETag": client.etag, "Cache-Control": "no-cache", "Vary": "Accept-Encoding"}
        if request.headers.get("if-none-match") == client.etag:
            return Response(status_code=304, headers=headers)
        if "gzip" in request.headers.get("accept-encoding", ""):
            headers["Content-Encoding"] = "gzip"
            return Response(client.compressed, headers=headers, media_type="text/html")
        return Response(client.html, headers=headers, media_type="text/html")

    @app.websocket("/view/{stage}")
    @app.websocket("/view/{stage}/")
    @app.websocket("/view/{stage}/{scheme}")
    @app.websocket("/view/{stage}/{scheme}/")
    async def view_socket(
        websocket: WebSocket, stage: str, visitor: Visitor, scheme: Scheme | None = None
    ) -> None:
        context: Context = websocket.app.state.context
        column = context.lineups.column(stage)
        if column is not None:
            opened, shown = column
            heard = opened.owner == visitor.voter
            await views.handle(shown, websocket, heard=heard, scheme=scheme)
            return
        try:
            found = context.stages.get(stage)
        except NotFoundError:
            await websocket.close(4404, "There is no such stage; load the page again.")
            return
        await views.handle(found, websocket, visitor.role is Role.AUTHOR, scheme)

    @app.get("/metrics", include_in_schema=False)
    async def tell_metrics() -> Response:
        return Response(metrics.told(), media_type=CONTENT_TYPE)

    app.mount("/web", StaticFiles(directory=web), name="web")
    earlier: frozenset[str] = frozenset()
    if settings.remember:
        earlier = earlier_runs(workspace.root, digest(cookie_of(settings.token)))
    people = People(settings.token, Tokens(store), earlier)
    app.state.people = people
    door = Door(settings.host, port, settings.public_url)
    app.add_middleware(Repeats, store=store)
    app.add_middleware(Guard, door=door, people=people)
    app.add_middleware(Requests, metrics=metrics)
    app.add_middleware(Health, ask=store.ask)
    return app


class _App(FastAPI):
    """FastAPI, which refuses bodies that are too large before any middleware, as problems."""

    def build_middleware_stack(self) -> ASGIApp:
        return problems.Sizes(super().build_middleware_stack())


def serve(settings: Settings, announce: Callable[[str], None]) -> None:
    """Run the studio until it is told to stop (Ctrl+C, SIGTERM).

    `announce` is called with the address, token included, once the server listens. Raises
    InvalidInputError where the port is taken.
    """
    listener = _listen(settings.host, settings.port)
    port = int(listener.getsockname()[1])
    try:
        app = create_app(settings, port)
    except BaseException:
        listener.close()
        raise
    shown = "127.0.0.1" if settings.host in {"0.0.0.0", "::"} else settings.host
    base = settings.public_url or f"http://{f'[{shown}]' if ':' in shown else shown}:{port}"

    settings.logs.begin()

    def listening() -> None:
        announce(f"{base}/?token={settings.token}")
        if settings.browser:
            # Whom this machine is shared with can read which address the browser was given.
            url = f"{base}/?token={app.state.people.code(time.monotonic())}"
            threading.Thread(target=webbrowser.open, args=(url,), daemon=True).start()

    def leaving() -> None:
        context: Context = app.state.context
        context.job_feed.close()

    # uvicorn ends cleanly at these and then raises them again, for the handlers set here.
    for number in (signal.SIGINT, signal.SIGTERM):
        signal.signal(number, lambda *_: None)
    _Server(configured(app, settings), listening, leaving).run(sockets=[listener])


def configured(app: FastAPI, settings: Settings) -> uvicorn.Config:
    """How uvicorn serves `app`."""
    return uvicorn.Config(
        app,
        log_config=None,
        log_level="warning",
        access_log=False,
        server_header=False,
        http=PatientProtocol,
        h11_max_incomplete_event_size=limits.MOST_HEAD_BYTES,
        limit_concurrency=limits.MOST_CONNECTIONS,
        proxy_headers=settings.behind_proxy is not None,
        forwarded_allow_ips=settings.behind_proxy,
        ws="websockets-sansio",
        ws_per_message_deflate=False,
        ws_max_size=limits.MOST_MESSAGE_BYTES,
        timeout_graceful_shutdown=GRACE_S,
    )


class _Server(uvicorn.Server):
    """uvicorn, telling when it listens, and when it is about to wait for what is open."""

    def __init__(
        self,
        config: uvicorn.Config,
        listening: Callable[[], None],
        leaving: Callable[[], None],
    ) -> None:
        super().__init__(config)
        self._listening = listening
        self._leaving = leaving

    async def shutdown(self, sockets: list[socket.socket] | None = None) -> None:
        """When it is done takes are closed and jobs gone: nobody waits for threads that hang."""
        self._leaving()
        await super().shutdown(sockets)
        leave = threading.Timer(LEAVE_S, os._exit, (0,))
        leave.daemon = True
        leave.start()

    async def startup(self, sockets: list[socket.socket] | None = None) -> None:
        # What is loaded by now stays for good. While it is looked through for garbage, which takes
        # 0.1 to 0.3 s, all stages wait; so that is done once, before there are any.
        load()
        gc.collect()
        gc.freeze()
        await super().startup(sockets)
        if not self.should_exit:
            self._listening()


def _listen(host: str, port: int) -> socket.socket:
    """A bound socket. Raises InvalidInputError, saying what to do, where that is impossible."""
    listener = None
    try:
        family, kind, protocol, _, address = socket.getaddrinfo(
            host, port, type=socket.SOCK_STREAM, flags=socket.AI_PASSIVE
        )[0]
        listener = socket.socket(family, kind, protocol)
        listener.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
        listener.bind(address)
        listener.listen(BACKLOG)  # from here on nobody else can have this port
    except (OSError, UnicodeError) as error:  # the latter for a name that can be no host's
        if listener is not None:
            listener.close()
        reason = getattr(error, "strerror", None) or error
        raise InvalidInputError(
            f"The studio cannot listen at {host} port {port}: {reason}. Choose another with "
            "--host and --port (0 takes any free port)."
        ) from None
    return listener
