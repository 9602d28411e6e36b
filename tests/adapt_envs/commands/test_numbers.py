"""Numbers on the command line are what they say, or refused."""

import argparse

import pytest

from adapt_envs.commands.numbers import positive


def test_a_whole_number_may_have_an_exponent():
    assert [positive(text) for text in ("1", "2e6", "3.0")] == [1, 2_000_000, 3]


@pytest.mark.parametrize("text", ["1.9", "0.5", "0", "-3", "inf", "nan", "many", "1e-3"])
def test_what_is_no_positive_whole_number_is_refused(text):
    with pytest.raises(argparse.ArgumentTypeError, match=f"'{text}' is not a positive whole number"):
        positive(text)
