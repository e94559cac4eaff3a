"""Stores that older versions wrote: `stores/version-N.db.gz` is a session recorded by one.

Each holds the two takes of `evastudio record asteroids --density 0.1 --minutes 0.7 --seed 4`,
cleaned, and what its version could keep besides: an evaluation from 2 on, a study from 3 on.
"""

from __future__ import annotations

import gzip
from pathlib import Path

from sqlalchemy import MetaData, create_engine, insert, select, text

FOLDER = Path(__file__).parent / "stores"
VERSIONS = (1, 2, 3)


def put_old_store(version: int, url: str, folder: Path) -> None:
    """Make the store at `url`, of either database, one that `version` wrote."""
    data = gzip.decompress((FOLDER / f"version-{version}.db.gz").read_bytes())
    if url.startswith("sqlite:///"):
        Path(url.removeprefix("sqlite:///")).write_bytes(data)
        return
    path = folder / f"version-{version}.db"
    path.write_bytes(data)
    source, target = create_engine(f"sqlite:///{path}"), create_engine(url)
    tables = MetaData()
    tables.reflect(source)
    with source.connect() as old, target.begin() as new:
        for table in tables.sorted_tables:
            for column in table.columns:
                column.type = column.type.as_generic()
        tables.create_all(new)
        for table in tables.sorted_tables:
            rows = [row._asdict() for row in old.execute(select(table))]
            if rows:
                new.execute(insert(table), rows)
            if "id" in table.columns:
                counter = f"pg_get_serial_sequence('{table.name}', 'id')"
                new.execute(text(f"SELECT setval({counter}, {max(len(rows), 1)})"))
    source.dispose()
    target.dispose()
