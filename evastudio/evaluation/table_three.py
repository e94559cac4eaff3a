"""The paper's table 3: people, how long it took them, and what they preferred."""

from __future__ import annotations

from collections.abc import Sequence

from evastudio.evaluation.preferences import Preference
from evastudio.evaluation.studies import Study

MINUTE = 60.0
PAPER_STUDIES = (
    ("Space ship", "Author", None, 7.0),
    ("Space ship", "Artist", 3.0, 9.5),
    ("Space ship", "Game player", 1.0, 8.5),
    ("Crowd", "Author", None, 12.0),
    ("Crowd", "Designer", 4.0, 13.0),
    ("Crowd", "Student", 3.0, 13.5),
)
"""Its table 3: test bed, user, minutes of instruction and of demonstration."""


def table_three(studies: Sequence[Study], preferences: Sequence[Preference] = ()) -> list[str]:
    """The paper's table 3 and every study stored, and blind votes beside, in Markdown."""
    rows = [(*row, "") for row in PAPER_STUDIES]
    lines = [
        "| | test bed | user | instruction | demonstration | preferred |",
        "|---|---|---|---:|---:|---|",
        *(
            f"| the paper | {bed} | {user} | {_minutes(taught)} | {_minutes(shown)} | {said} |"
            for bed, user, taught, shown, said in rows
        ),
    ]
    for one in studies:
        taught = None if one.instructed_s is None else one.instructed_s / MINUTE
        lines.append(
            f"| here | {one.scene} | {_cell(one.person)} | {_minutes(taught)} "
            f"| {_minutes(one.demonstrated_s / MINUTE)} | {_cell(one.preferred or '')} |"
        )
    lines += ["", "In the paper all preferred their own policies to traditional ones."]
    if not studies:
        lines.append("No study is stored yet.")
    if preferences:
        lines += [
            "",
            "Which of two was livelier, shown side by side in the same worlds without names. The "
            "interval (95 %, Wilson) is of the share of the first among the votes for either, and "
            "takes votes for independent.",
            "",
            "| test bed | livelier | than | votes | no difference | people | share |",
            "|---|---|---|---:|---:|---:|---:|",
            *(_preferred(one) for one in preferences),
        ]
    return lines


def _preferred(found: Preference) -> str:
    ahead, behind = found.leading, 1 - found.leading
    share = ""
    if found.share is not None and found.interval is not None:
        low, high = found.interval
        share = f"{100 * found.share:.0f} % ({100 * low:.0f} to {100 * high:.0f})"
    return (
        f"| {found.scene} | {_cell(found.pilots[ahead])} | {_cell(found.pilots[behind])} "
        f"| {found.votes[ahead]} to {found.votes[behind]} | {found.neither} | {found.people} "
        f"| {share} |"
    )


def _minutes(value: float | None) -> str:
    return "" if value is None else f"{value:g} min"


def _cell(text: str) -> str:
    """What somebody wrote, as it stands in one cell of a table."""
    return " ".join(text.split()).replace("|", "\\|")
