"""EVA Studio: policies for virtual characters, learned from demonstrations.

The same functions as the command line: `record`, `import_walks`, `sessions`, `clean`, `diagnose`,
`tune`, `fit`, `search`, `evaluate`, `evaluations`, `repeat_evaluation`, `studies`, `scenes`,
`backup`, `restore`, `check`; each but `check` takes a `Workspace` first. Importing the package
registers every shipped scene with Gymnasium: `gymnasium.make("evastudio/Asteroids-v0")`.
"""

from __future__ import annotations

from importlib import import_module
from typing import TYPE_CHECKING, Any

import gymnasium

from evastudio.workspace import shipped

if TYPE_CHECKING:
    from evastudio.learning.policy_files import load_policy, save_policy
    from evastudio.live.backups import backup, restore
    from evastudio.live.cleaning import clean
    from evastudio.live.diagnosing import diagnose
    from evastudio.live.evaluating import evaluate, evaluations, repeat_evaluation
    from evastudio.live.headless import fit, record, scenes, sessions
    from evastudio.live.importing import import_walks
    from evastudio.live.reproducing import paper
    from evastudio.live.searching import search
    from evastudio.live.studying import studies
    from evastudio.live.switching import switch
    from evastudio.live.tuning import tune
    from evastudio.workspace import Workspace
    from evastudio.world.check import check_file as check

__version__ = "0.1.0"

_FROM = {
    "Workspace": "evastudio.workspace",
    "backup": "evastudio.live.backups",
    "check": "evastudio.world.check",
    "clean": "evastudio.live.cleaning",
    "diagnose": "evastudio.live.diagnosing",
    "evaluate": "evastudio.live.evaluating",
    "evaluations": "evastudio.live.evaluating",
    "fit": "evastudio.live.headless",
    "import_walks": "evastudio.live.importing",
    "load_policy": "evastudio.learning.policy_files",
    "paper": "evastudio.live.reproducing",
    "record": "evastudio.live.headless",
    "save_policy": "evastudio.learning.policy_files",
    "scenes": "evastudio.live.headless",
    "repeat_evaluation": "evastudio.live.evaluating",
    "restore": "evastudio.live.backups",
    "search": "evastudio.live.searching",
    "sessions": "evastudio.live.headless",
    "studies": "evastudio.live.studying",
    "switch": "evastudio.live.switching",
    "tune": "evastudio.live.tuning",
}

__all__ = [
    "Workspace",
    "backup",
    "check",
    "clean",
    "diagnose",
    "evaluate",
    "evaluations",
    "fit",
    "import_walks",
    "load_policy",
    "paper",
    "record",
    "repeat_evaluation",
    "restore",
    "save_policy",
    "scenes",
    "search",
    "sessions",
    "studies",
    "switch",
    "tune",
]


def __getattr__(name: str) -> Any:
    """Import on first use, so that `import evastudio` itself stays quick."""
    if name not in _FROM:
        raise AttributeError(f"module 'evastudio' has no attribute {name!r}")
    return getattr(import_module(_FROM[name]), "check_file" if name == "check" else name)


for _scene in sorted((shipped() / "scenes").glob("*.py")):
    gymnasium.register(
        id=f"evastudio/{_scene.stem.title().replace('_', '')}-v0",
        entry_point="evastudio.world.environment:SceneEnvironment",
        vector_entry_point="evastudio.world.vector_environment:SceneVectorEnvironment",
        kwargs={"scene": _scene.stem},
    )
