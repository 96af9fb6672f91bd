"""An answer in words, as the terminal, the picture, the page and the diagnostics print it."""

from __future__ import annotations

from collections.abc import Mapping

UNKNOWN = "unknown object"


def percent(share: float) -> str:
    """A share of 1 as a percentage: 0.96 is "96 %"."""
    return f"{100.0 * share:.0f} %"


def answer_parts(
    label: str,
    probability: float,
    in_distribution: bool = True,
    alternatives: Mapping[str, float] | None = None,
) -> tuple[str, str]:
    """The name of an answer and its figures.

    Args:
        label: The most probable class.
        probability: Its probability, 0 … 1.
        in_distribution: See `Prediction`.
        alternatives: See `Prediction`; None or empty where the label stands alone.

    Returns:
        ("bathtub", "96 %"), ("table or desk", "55 % / 41 %") or ("unknown object",
        "nearest: chair 41 %").
    """
    if not in_distribution:
        return UNKNOWN, f"nearest: {label} {percent(probability)}"
    shown = alternatives or {label: probability}
    return " or ".join(shown), " / ".join(map(percent, shown.values()))


def answer_text(
    label: str,
    probability: float,
    in_distribution: bool = True,
    alternatives: Mapping[str, float] | None = None,
) -> str:
    """Both of `answer_parts` in one line: "bathtub (96 %)"."""
    name, figures = answer_parts(label, probability, in_distribution, alternatives)
    return f"{name} ({figures})"


def truth_text(label: str, in_distribution: bool, truth: str) -> str:
    """How an answer compares with the ground truth.

    Args:
        label: The most probable class.
        in_distribution: See `Prediction`; an unknown object is neither correct nor incorrect.
        truth: The true class.
    """
    if not in_distribution:
        return f"the true class is {truth}"
    return "correct" if label == truth else f"incorrect: the true class is {truth}"
