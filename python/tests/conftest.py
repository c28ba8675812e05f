"""What the tests share: the examples, and the planar translation at 100 steps, solved once."""
import pathlib

import pytest

import lamprey as lp

ROOT = pathlib.Path(__file__).resolve().parents[2]


@pytest.fixture(scope="session")
def root():
    return ROOT


@pytest.fixture(scope="session")
def translation():
    return lp.load(ROOT / "examples" / "translation.toml").changed(time={"steps": 100})


@pytest.fixture(scope="session")
def solution(translation):
    return lp.solve(translation)


@pytest.fixture(scope="session")
def three_links():
    return lp.load(ROOT / "examples" / "three_links.toml")
