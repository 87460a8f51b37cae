"""Machines that lack what API mode needs: Python's C headers, or a compiler."""

from __future__ import annotations

import numpy as np
import pytest
from core_designs import Variant, design, package

from servogen.controllers.cascade import Cascade
from servogen.errors import InputError
from servogen.sil import build
from servogen.sil.compiled import CompiledController
from servogen.sil.harness import compare
from servogen.sil.scenarios import suite

SMALL = Variant(prefix="bare", horizon=2, points=5, ramp=1, cap=20)


def test_without_pythons_headers_the_library_mode_computes_the_same(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setattr(build, "has_python_headers", lambda: False)
    with build.built(package(SMALL)) as module:
        assert type(module).__name__ == "SimpleNamespace"
        for case in suite(design(SMALL), 3, 20):
            reference = case.reference()
            compiled = CompiledController(module, reference.declaration)
            agreement = compare(reference, compiled, case.calls)
            assert agreement.passed, f"{case.name}: {agreement.difference}"
        cascade = Cascade(design(SMALL))
        compiled = CompiledController(module, cascade.declaration)
        assert np.array_equal(cascade.repeat("fast_step", 7), compiled.repeat("fast_step", 7))


def test_without_a_compiler_one_sentence_says_what_to_install(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setenv("PATH", "")
    with (
        pytest.raises(InputError, match="gcc is missing, expected a C compiler"),
        build.built(package(SMALL)),
    ):
        pass
