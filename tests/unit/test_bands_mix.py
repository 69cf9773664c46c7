"""mix in bands: as sharp as its operands, and never sharper than what a device may compute."""

from __future__ import annotations

import numpy as np
import pytest

from benchmarks.adversary_device import Device
from shaderlab import glslmath as g
from shaderlab.bands import Band, functions

F = np.float32
COUNT = 20_000


def drawn(seed: int, scale: float) -> tuple[Band, np.ndarray]:
    """Bands of some width, and a float32 in each."""
    rng = np.random.default_rng(seed)
    middle = rng.uniform(-scale, scale, (COUNT, 1))
    wide = 10.0 ** rng.uniform(-9.0, -1.0, (COUNT, 1))
    band = Band.between(middle - wide, middle + wide)
    chosen = (band.lo + (band.hi - band.lo) * rng.integers(0, 2, (COUNT, 1))).astype(F)
    return band, chosen


def computed(x: np.ndarray, y: np.ndarray, a: np.ndarray) -> list[np.ndarray]:
    """mix as devices compute it: by either formula, contracted, and distributed."""
    one = F(1.0)
    contracted = (x.astype(float) * (one - a) + (y * a).astype(float)).astype(F)
    raised = ((y - x).astype(float) * a + x).astype(F)
    return [
        x * (one - a) + y * a, x + (y - x) * a, contracted, raised, x - x * a + y * a,
        (y * a - x * a) + x, x + (y * a - x * a),
    ]  # fmt: skip


@pytest.mark.parametrize("scale", [1.0, 1e-3, 1e6, 1e-37])
@pytest.mark.parametrize("of_a", [1.0, 50.0])
def test_what_devices_compute_is_inside(scale: float, of_a: float) -> None:
    (x, at_x), (y, at_y), (a, at_a) = drawn(1, scale), drawn(2, scale), drawn(3, of_a)
    band = g.mix(x, y, a)
    for result in computed(at_x, at_y, at_a):
        assert band.contains(result).all()
    beyond = np.nextafter(F(band.hi.max()), F(np.inf))
    assert not band.contains(np.full((COUNT, 1), beyond)).any()


def nested(depth: int) -> float:
    """The width of so many mixes, each of the one before, by shares that are known to 1e-5."""
    color = Band.between([0.2], [0.2001])
    for _ in range(depth):
        color = g.mix(color, 0.85, Band.between([0.3], [0.30001]))
    return float((color.hi - color.lo)[0])


def test_mixing_again_and_again_does_not_widen(monkeypatch: pytest.MonkeyPatch) -> None:
    assert nested(6) < nested(1) < 1e-4
    monkeypatch.setattr(functions, "cut_to_ends", lambda found, *_: found)
    assert nested(6) > 5e-4  # by the operations alone


def added(device: Device, terms: list[np.ndarray]) -> np.ndarray:
    """Terms added up in any order."""
    order = device.rng.permutation(len(terms))
    total = terms[order[0]]
    for k in order[1:]:
        total = device.add(total, terms[k])
    return total


@pytest.mark.parametrize(
    ("least", "most"), [(0.0, 1.0), (0.0, 1e-6), (1.0 - 1e-6, 1.0), (-2.0, 3.0)]
)
def test_no_order_of_nested_mixes_leaves_the_band(least: float, most: float) -> None:
    """Each mix by another form, some multiplied out, their sums taken apart and joined anew."""
    found = []
    for seed in range(12):
        device = Device(seed, "either")
        rng = device.rng
        first, *colors = (
            rng.uniform(-1.0, 1.0, (500, 1)).astype(F).astype(float) for _ in range(5)
        )
        terms, band = [first], Band.exact(first)
        for color in colors[:-1]:
            a = rng.uniform(least, most, (500, 1)).astype(F).astype(float)
            band = g.mix(band, Band.exact(color), Band.exact(a))
            x, form = added(device, terms), rng.integers(0, 4)
            if form == 0:
                terms = [device.mul(x, device.add(np.ones(1), -a)), device.mul(color, a)]
            elif form == 1:
                terms = [*terms, device.mul(device.add(color, -x), a)]
            elif form == 2:
                terms = [*terms, device.mul(-x, a), device.mul(color, a)]
            else:
                products = [device.mul(-term, a) for term in terms]
                terms = [*terms, *products, device.mul(color, a)]
        last = colors[-1]
        found += [
            (band, added(device, terms)),
            (band + Band.exact(last), added(device, [*terms, last])),
            (band * Band.exact(last), added(device, [device.mul(last, term) for term in terms])),
        ]
    assert all(band.contains(values.astype(F)).all() for band, values in found)
    assert not any(band.contains(values.astype(F) + F(1e-4)).all() for band, values in found)


def test_terms_of_nested_mixes_add_up_and_do_not_multiply() -> None:
    color = Band.exact([[0.5]])
    for _ in range(8):
        color = g.mix(color, 0.75, 1.0 - Band.exact([[0.5]]))
    assert color.abs_sum[0, 0] < 20.0 and color.count < 20


def test_a_share_of_0_gives_the_first_colour_as_it_is() -> None:
    x = Band.exact([[0.3]]) + 0.1
    band = g.mix(x, 0.7, Band.exact([[0.0], [0.5]]))
    settled = x.apply_slack()[1] - x.apply_slack()[0]
    assert (band.hi - band.lo)[0] < settled + 1e-7 < (band.hi - band.lo)[1]


def test_what_has_no_end_stays_open() -> None:
    x, a = Band.exact([[1.0]]), Band.between([[0.0]], [[np.inf]])
    band = g.mix(x, 2.0, a)
    assert band.contains(F(np.inf)).all() and band.contains(F(3e38)).all()
    assert g.mix(x, Band.exact([[0.0]]) / 0.0, Band.exact([[0.0]])).contains(F(7.0)).all()
