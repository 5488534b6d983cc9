# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Whatever stands in a problem's tables: a typed error that names it or numbers that are numbers,
never a crash.

A campaign of more: HULLRECON_DAMAGED_PROBLEMS=10000 pytest tests/native/test_damaged_problems.py
"""

from __future__ import annotations

import dataclasses
import os
from collections.abc import Callable

import numpy as np
import pytest
from drafts import Draft, change, covariance, evaluate, leaves, solve
from native.test_cores import links, no_landmarks, planes

from hullrecon.errors import InputError, StageError, UsageError
from hullrecon.native import Options, pair_covariance

pytestmark = pytest.mark.slow
BATCH = 50
BATCHES = -(-int(os.environ.get("HULLRECON_DAMAGED_PROBLEMS", "300")) // BATCH)
TYPED = (InputError, StageError, UsageError)
NUMBERS = (0.0, -1.0, 1e-300, 1e300, -1e12, 1e6, np.nan, np.inf, -np.inf)
INDICES = (-1, 0, 1, 7, 8, 59, 60, 2**31 - 1, -(2**31))

Survey = Callable[..., Draft]
Damage = Callable[[np.ndarray, np.random.Generator], np.ndarray]


def wild(table: np.ndarray) -> tuple[float, ...]:
    return INDICES if table.dtype.kind == "i" else NUMBERS


def one_number(table: np.ndarray, rng: np.random.Generator) -> np.ndarray:
    out = table.copy()
    out.ravel()[rng.integers(out.size)] = rng.choice(wild(table))
    return out


def all_numbers(table: np.ndarray, rng: np.random.Generator) -> np.ndarray:
    return np.full_like(table, rng.choice(wild(table)))


def scaled(table: np.ndarray, rng: np.random.Generator) -> np.ndarray:
    return table * table.dtype.type(rng.choice([-1, 0, 1000]))


def noisy(table: np.ndarray, rng: np.random.Generator) -> np.ndarray:
    return table + (rng.normal(0, 10.0 ** rng.integers(-4, 4), table.shape)).astype(table.dtype)


def a_row_less(table: np.ndarray, _: np.random.Generator) -> np.ndarray:
    return table[:-1]


def empty(table: np.ndarray, _: np.random.Generator) -> np.ndarray:
    return table[:0]


def shuffled(table: np.ndarray, rng: np.random.Generator) -> np.ndarray:
    return np.asarray(rng.permutation(table))


def flat(table: np.ndarray, _: np.random.Generator) -> np.ndarray:
    return table.ravel()


def of_another_type(table: np.ndarray, rng: np.random.Generator) -> np.ndarray:
    return table.astype(rng.choice([np.float32, np.int64, np.complex128, np.bool_]))


DAMAGES: tuple[Damage, ...] = (
    one_number,
    one_number,
    one_number,
    all_numbers,
    scaled,
    noisy,
    a_row_less,
    empty,
    shuffled,
    flat,
    of_another_type,
)


def damaged(p: Draft, rng: np.random.Generator) -> Draft:
    """Between one and four of its tables."""
    names = [
        path for path, value in leaves(p).items() if isinstance(value, np.ndarray) and value.size
    ]
    for name in rng.choice(names, rng.integers(1, 5)):
        table = leaves(p)[name]
        if table.size:
            change(p, name, DAMAGES[rng.integers(len(DAMAGES))](table, rng))
    return p


def chosen(rng: np.random.Generator) -> Options:
    return Options(
        method=str(rng.choice(["naive", "geva", "maxmix"])),
        core=str(rng.choice(["schur", "schur", "schur", "ceres"])),
        sigma_on=float(rng.choice([0.02, 1e-9])),
        huber_stereo=float(rng.choice([2.508, np.inf, 1e-12])),
        huber_mono=float(rng.choice([1.856, np.inf, 1e-12])),
        max_iterations=int(rng.integers(0, 6)),
        threads=int(rng.integers(1, 3)),
    )


def solved(p: Draft, options: Options) -> list[np.ndarray]:
    return list(vars(solve(p, options).unknowns).values())


def evaluated(p: Draft, options: Options) -> list[np.ndarray]:
    return list(evaluate(p, options).cost_by_factor.values())


def marginals(p: Draft, options: Options) -> list[np.ndarray]:
    found = dataclasses.asdict(covariance(p, options))
    return [*found.pop("leverage_by_factor").values(), *found.values()]


def answer(call: Callable[[Draft, Options], list[np.ndarray]], p: Draft, options: Options) -> str:
    """The words with which it is refused, or "numbers", or "no numbers"."""
    try:
        values = call(p, options)
    except TYPED as error:
        return str(error).strip()
    return "numbers" if all(np.isfinite(v).all() for v in values) else "no numbers"


def joint(p: Draft, options: Options) -> list[np.ndarray]:
    return list(vars(pair_covariance(p.build(), np.array([[0, 3], [5, 1]]), options)).values())


@pytest.mark.filterwarnings("ignore::RuntimeWarning", "ignore::numpy.exceptions.ComplexWarning")
@pytest.mark.parametrize("batch", range(BATCHES // 2))
def test_damaged_pose_graph_is_refused_or_solved(
    batch: int, make_survey: Survey, shaken: Survey
) -> None:
    answers = {}
    for seed in range(batch * BATCH, (batch + 1) * BATCH):
        rng = np.random.default_rng(seed)
        p, options = shaken(make_survey(landmarks=25), seed=seed), chosen(rng)
        for change_it in (links, planes, no_landmarks):
            change_it(p)
        p = damaged(p, rng)
        answers |= {
            (seed, call.__name__): answer(call, p, options)
            for call in (solved, evaluated, marginals, joint)
        }
    assert {key for key, said in answers.items() if said in ("", "no numbers")} == set()
    assert sum(said == "numbers" for said in answers.values()) > BATCH / 10, (
        "too much was damaged to tell"
    )


@pytest.mark.filterwarnings("ignore::RuntimeWarning", "ignore::numpy.exceptions.ComplexWarning")
@pytest.mark.parametrize("batch", range(BATCHES))
def test_damaged_problem_is_refused_or_solved(
    batch: int, make_survey: Survey, shaken: Survey
) -> None:
    answers = {}
    for seed in range(batch * BATCH, (batch + 1) * BATCH):
        rng = np.random.default_rng(seed)
        p, options = damaged(shaken(make_survey(landmarks=25), seed=seed), rng), chosen(rng)
        answers |= {
            (seed, call.__name__): answer(call, p, options)
            for call in (solved, evaluated, marginals)
        }
    assert {key for key, said in answers.items() if said in ("", "no numbers")} == set()
    solvable = sum(said == "numbers" for said in answers.values())
    assert BATCH / 10 < solvable < 2.5 * BATCH, "too much or too little was damaged to tell"
