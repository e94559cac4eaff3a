"""What a finding says to somebody who animates: no fields, no figures of theirs, what to do."""

from __future__ import annotations

from evastudio.learning.finding import Finding

_COPIES = (
    "Some of what the character sees all but repeats your own moves: judge this by letting it "
    "play, or choose something else for it to see."
)
_HIDDEN = (
    "What you did does not follow from what the character sees: react later and more visibly, "
    "and keep farther away from what you avoid."
)


def in_short(finding: Finding) -> str:
    """One sentence on what to do about something that was found."""
    match finding.name:
        case "copies":
            return _COPIES
        case "hidden":
            return _HIDDEN
        case "thin":
            return (
                f"{100 * finding.measure:.0f} % of the moments are like nothing in your other "
                "takes: show more of what you did only once, or press O to be taken where you "
                "have not been."
            )
        case _:
            return finding.sentence
