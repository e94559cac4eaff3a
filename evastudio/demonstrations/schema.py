"""The tables of the session store, and the versions they went through."""

from __future__ import annotations

from sqlalchemy import (
    BigInteger,
    Column,
    Float,
    ForeignKey,
    Index,
    Integer,
    LargeBinary,
    MetaData,
    String,
    Table,
    Text,
)

VERSION = 9
"""Raised with every change of the tables; a store of a newer version is refused. 2 added the
evaluations, 3 the studies, 4 where takes come from, what people note of them and what their
writers call them, 5 the tokens, 6 the keys of takes that were deleted, 7 the
answers to requests that may be repeated, 8 what people say of single pairs, 9 the ballots and
their votes."""

metadata = MetaData()

store = Table(
    "evastudio_store",
    metadata,
    Column("version", Integer, nullable=False),
    Column("identity", String(40), nullable=False),
)
"""One row. `identity` tells this store from every other, so that a policy knows its own."""

sessions = Table(
    "sessions",
    metadata,
    Column("id", Integer, primary_key=True),
    Column("name", String(200), nullable=False),
    Column("scene", String(200), nullable=False),
    Column("scene_version", Integer, nullable=False),
    Column("demonstrator", String(200), nullable=False),
    Column("created_at", Float, nullable=False),
    Column("made_by", Text, nullable=False),
)

takes = Table(
    "takes",
    metadata,
    Column("id", Integer, primary_key=True),
    Column("session_id", ForeignKey("sessions.id"), nullable=False, index=True),
    Column("number", Integer, nullable=False),
    Column("scene_version", Integer, nullable=False),
    Column("seed", BigInteger, nullable=False),
    Column("options", Text, nullable=False),
    Column("dt_s", Float, nullable=False),
    Column("pilot", String(200), nullable=False),
    Column("perception", String(200), nullable=False),
    Column("started_at", Float, nullable=False),
    Column("ended_at", Float),
    Column("outcome", String(200)),
    Column("trashed_at", Float),
    Column("origin", Text),
    Column("note", Text),
    Column("key", String(80)),
    Column("fixed", LargeBinary, nullable=False),
    Index("takes_number", "session_id", "number", unique=True),
    Index("takes_key", "key", unique=True),
    sqlite_autoincrement=True,  # the id of a deleted take is never another's
)
"""`origin` is JSON, the moment of another run that a take goes on from. `key` is what its writer
calls a take, so that one who was cut off while it began does not begin another. `fixed` holds the
unchanging arrays of the world, packed: the largest by far, and last, so that listing takes does
not read past it."""

chunks = Table(
    "chunks",
    metadata,
    Column("take_id", ForeignKey("takes.id"), primary_key=True),
    Column("first_step", Integer, primary_key=True),
    Column("steps", Integer, nullable=False),
    Column("arrays", LargeBinary, nullable=False),
    Index("chunks_steps", "take_id", "steps"),
)
"""States, actions and moving arrays, packed: half a second each while the take runs, joined into
few when it has ended."""

cleanings = Table(
    "cleanings",
    metadata,
    Column("id", Integer, primary_key=True),
    Column("session_id", ForeignKey("sessions.id"), nullable=False, index=True),
    Column("created_at", Float, nullable=False),
    Column("settings", Text, nullable=False),
)

marks = Table(
    "marks",
    metadata,
    Column("cleaning_id", ForeignKey("cleanings.id"), primary_key=True),
    Column("take_id", ForeignKey("takes.id"), primary_key=True),
    Column("pairs", Integer, nullable=False),
    Column("removed", Integer, nullable=False),
    Column("mask", LargeBinary, nullable=False),
)
"""One bit for each pair of a take that a cleaning looked at."""

verdicts = Table(
    "verdicts",
    metadata,
    Column("take_id", ForeignKey("takes.id"), primary_key=True),
    Column("step", Integer, primary_key=True),
    Column("verdict", String(20), nullable=False),
)
"""What a person said of a pair that conflicts with others; see `Verdict`."""

evaluations = Table(
    "evaluations",
    metadata,
    Column("id", Integer, primary_key=True),
    Column("scene", String(200), nullable=False, index=True),
    Column("created_at", Float, nullable=False),
    Column("asked", Text, nullable=False),
    Column("versions", Text, nullable=False),
    Column("result", Text, nullable=False),
    Column("arrays", LargeBinary, nullable=False),
)
"""`asked` is what makes it again, `result` the summary, `arrays` every world's figures, packed."""

studies = Table(
    "studies",
    metadata,
    Column("id", Integer, primary_key=True),
    Column("scene", String(200), nullable=False, index=True),
    Column("created_at", Float, nullable=False),
    Column("told", Text, nullable=False),
)
"""`told` is the study as JSON."""

tokens = Table(
    "tokens",
    metadata,
    Column("id", Integer, primary_key=True),
    Column("name", String(80), nullable=False, index=True),
    Column("role", String(20), nullable=False),
    Column("digest", String(64), nullable=False, unique=True),
    Column("cookie", String(64), nullable=False, unique=True),
    Column("created_at", Float, nullable=False),
    Column("revoked_at", Float),
)
"""`digest` is the SHA-256 of the secret, `cookie` that of the cookie made from it."""

deleted_takes = Table("deleted_takes", metadata, Column("key", String(80), primary_key=True))
"""Keys of takes that were deleted: their writers, who may still hold pairs, do not bring them
back."""

answers = Table(
    "answers",
    metadata,
    Column("key", String(64), primary_key=True),
    Column("digest", String(64), nullable=False),
    Column("started_at", Float, nullable=False, index=True),
    Column("status", Integer),
    Column("media_type", String(200)),
    Column("body", LargeBinary),
)
"""What was answered to a request with an idempotency key, for a day; no status while it is not
answered yet. `key` is the SHA-256 of whose it is and the key, `digest` that of the request."""

ballots = Table(
    "ballots",
    metadata,
    Column("id", Integer, primary_key=True),
    Column("scene", String(200), nullable=False, index=True),
    Column("created_at", Float, nullable=False),
    Column("asked", Text, nullable=False),
    Column("secret", String(64), nullable=False),
)
"""`asked` is JSON, who is to be chosen between and in which worlds; `secret` decides in which order
the two are shown, and stays here."""

votes = Table(
    "votes",
    metadata,
    Column("ballot_id", ForeignKey("ballots.id"), primary_key=True),
    Column("voter", String(80), primary_key=True),
    Column("number", Integer, primary_key=True),
    Column("created_at", Float, nullable=False),
    Column("on_left", Integer, nullable=False),
    Column("chosen", Integer),
)
"""`voter` is whose token it was, empty for that of the run; `number` which of their votes, and of
the ballot's worlds. `on_left` is which of the two pilots stood left, `chosen` which was preferred,
none where they saw no difference."""
