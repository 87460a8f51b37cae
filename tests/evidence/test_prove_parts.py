"""Nobody but a part touches its state, and what is analysed is what is compiled."""

from __future__ import annotations

import pytest
from core_designs import Variant, package
from small_bench import changed

from servogen.evidence.prove_parts import Job, meddling, other_texts

SMALL = Variant("eva", horizon=3, points=8, ramp=2, cap=12)
BARE = Variant("eva0", horizon=0, points=5, ramp=0, precision="float32")
FAST, CASCADE = "eva0_follower", "eva0"
INIT = "    eva0_follower_init(&self->fast);\n"
HANDS = {
    "an element": "self->fast.path_x[0] = 1.0f;",
    "a pointer": "eva0_follower_t *part = &self->fast; part->head = 9999;",
    "an address": "(&self->fast)->head = 9999;",
    "brackets": "(self->fast).head = 9999;",
    "a star": "(*self).fast.head = 9999;",
    "a kernel": "sg_fill(1, 9.0e30f, &self->fast.along);",
    "a cast": "sg_fill(1, 9.0e30f, (sg_real *)&self->fast);",
    "a pointer to void": "void *part = &self->fast; sg_real *first = part; first[0] = 9.0e30f;",
    "the whole": "eva0_follower_t junk; eva0_follower_init(&junk); *(&self->fast) = junk;",
    "a look": "self->along = self->fast.along;",
    "what init leaves": "self->fast.begun = 20071;",
}


@pytest.mark.parametrize("name", HANDS)
def test_a_hand_on_the_state_of_a_part_is_seen(name, tmp_path):
    made = changed(package(BARE), f"{CASCADE}.c", INIT, f"{INIT}    {{ {HANDS[name]} }}\n")
    made.write(tmp_path)
    assert meddling(Job(made, made.declarations[-1], "any"), tmp_path)


@pytest.mark.parametrize("v", [SMALL, BARE], ids=lambda v: v.prefix)
def test_the_cascades_leave_their_parts_alone(v, tmp_path):
    made = package(v)
    made.write(tmp_path)
    for d in made.declarations:
        assert meddling(Job(made, d, "any"), tmp_path) == []
    assert other_texts(made) == []


@pytest.mark.parametrize(
    "text", ["#ifndef __FRAMAC__", "#if SG_EVA_INPUTS", "#ifdef SG_OWN_DIVISION"]
)
def test_c_that_the_analyser_would_not_see_is_refused(text):
    made = changed(package(BARE), f"{FAST}.c", "/* The point `along`", f"{text}\n#endif\n/* The")
    (fault,) = other_texts(made)
    assert f"{FAST}.c" in fault


def test_a_state_within_its_bounds_is_given_as_constant(tmp_path):
    made = changed(
        package(SMALL), "eva.c", "eva_mpc_init(&self->mpc_x);",
        "eva_mpc_init(&self->mpc_x); sg_fill(1, (sg_real)0, self->mpc_x.predicted);",
    )  # fmt: skip
    made.write(tmp_path)
    (fault,) = meddling(Job(made, made.declarations[-1], "any"), tmp_path)
    assert "qualifier" in fault
