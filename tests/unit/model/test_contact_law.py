"""A contact law: what is none is refused where it is made."""

from __future__ import annotations

import numpy as np
import pytest

from creak.contact.laws.parameters import laid_over
from creak.errors import InputError
from creak.model.contact_law import ContactLaw, Coulomb

CURVE = np.array([[0.0, 0.0], [1e-3, 2e6], [3e-3, 3e6]])


@pytest.mark.parametrize(
    ("numbers", "message"),
    [
        ({"stiffness": -1.0}, r"study.toml:7 stiffness: stiffness = -1; expected zero or more"),
        ({"stiffness": np.nan}, r"stiffness = nan"),
        ({"damping": -2.0}, r"study.toml:7 damping: damping = -2"),
        ({"stiffness": 1.0, "preload": -5.0}, r"study.toml:7 preload: preload = -5"),
        ({"stiffness": np.inf, "preload": 5.0}, r"preload = 5 without a finite stiffness"),
        ({"stiffness": 5.0, "curve": CURVE}, r"overclosure: both stiffness = 5.0 and an overclosure curve"),
        ({"curve": CURVE[::-1]}, r"overclosure: the overclosure curve starts at \[0.003, 3000000.0\]"),
        ({"friction": Coulomb(0.2, 0.3)}, r"friction: friction with static = 0.2, kinetic = 0.3, decay = 0"),
        ({"friction": Coulomb(0.2, 0.1, np.inf)}, r"decay = inf; expected 0 <= kinetic <= static and decay >= 0"),
    ],
)
def test_what_is_no_law_is_refused(numbers, message):
    with pytest.raises(InputError, match=message):
        ContactLaw(**numbers, where="study.toml:7")


def test_a_law_on_channels_is_its_numbers_times_their_scale():
    law = ContactLaw(curve=CURVE, damping=3.0, friction=Coulomb(0.3, 0.2, 5.0))
    on = laid_over(law, np.array([2.0, 4.0]))
    np.testing.assert_allclose(on["stiffness"], [4e9, 8e9], rtol=1e-12)  # the steepest part of the curve
    np.testing.assert_array_equal(on["damping"], [6.0, 12.0])
    np.testing.assert_array_equal(on["curves"].scale, [2.0, 4.0])
    np.testing.assert_array_equal(on["friction"].decay, 5.0)
    assert not on["step_limited"].any()
    assert on["preload"] is None


def test_the_elements_say_what_the_law_leaves_open():
    on = laid_over(ContactLaw(), np.array([2.0, 4.0]), np.array([10.0, 20.0]))
    np.testing.assert_array_equal(on["stiffness"], [20.0, 80.0])
    assert on["step_limited"].all()
    assert on["friction"] is None
    with pytest.raises(ValueError, match="without stiffness on channels without elements"):
        laid_over(ContactLaw(), np.ones(2))
