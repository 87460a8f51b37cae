"""First-move laws by what holds where they apply: which moves of the plan stand at a bound."""

from __future__ import annotations

from servogen.explicit.solution import ExplicitSolution
from servogen.reports.numbers import MINUS, count

MEANING = (
    "u0 is the move that is given, u1, u2 and so on those planned after it; + at its upper limit, "
    f"{MINUS} at its lower one"
)
# Of a legend that is still one.
_MOST_WORDS = 4


def law_names(solution: ExplicitSolution) -> list[str]:
    """For every law the region with the fewest active constraints of those that share it, in the
    words of ``MEANING``."""
    found = []
    for law in range(solution.laws.count):
        own = [region.active for region in solution.regions if region.law == law]
        found.append(_pattern(solution, min(own, key=lambda active: (len(active), active))))
    return found


def _pattern(solution: ExplicitSolution, active: tuple[int, ...]) -> str:
    problem = solution.problem
    rows, moves = problem.rows.shape[0], problem.variables
    other = sum(number < rows for number in active)
    words = []
    for number in sorted(active, key=lambda each: (each - rows) % moves):
        if number >= rows:
            words.append(f"u{(number - rows) % moves}{'+' if number < rows + moves else MINUS}")
    if words and words[0][:-1] == "u0":
        return words[0]  # whatever the later ones do
    if len(words) > _MOST_WORDS:
        words = [*words[:_MOST_WORDS], "..."]
    if other:
        words.append(f"{other} more" if words else f"{count(other, 'limit')}")
    return " ".join(words) or "free"
