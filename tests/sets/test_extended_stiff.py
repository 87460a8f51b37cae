"""P-tilde of a stage twice as fast as the paper's: another size known beforehand."""

from extended_sets import paper_set, stage

from servogen.sets.auxiliary import shift_register
from servogen.sets.extended_proofs import prove_extended_admissibility, prove_extended_invariance


def test_size_and_proofs_of_a_stiff_stage() -> None:
    target = paper_set(40.0, shift_register(40))
    assert (target.inequalities, 2 * len(target.h_x)) == (764, 510)
    assert prove_extended_invariance(target, stage(40.0)).holds
    assert prove_extended_admissibility(target, stage(40.0)).holds
