"""Bending of a wire held at its root by a torsion spring: the frequencies of the beam and of its
chain of links.

A uniform Euler-Bernoulli beam of length L, mass m and bending stiffness E I_a, hinged at a root
that a torsion spring k_T holds and free at the other end, vibrates at omega = lambda^2 sqrt(E
I_a/(m L^3)), where lambda solves

    sin(lambda) cosh(lambda) - cos(lambda) sinh(lambda) = (k_T L/(E I_a)) (1 + cos(lambda) cosh(lambda))/lambda.

Without the spring this is tan = tanh, the hinged beam; with a rigid spring it is the cantilever.

The chain is n equal rigid links of length l = L/n and mass m/n, hinged end to end with the torsion
spring E I_a/l in each hinge. Unlike the beam, its first link does not bend at the root. With the
root spring k_T its frequencies therefore tend to those of the beam with an error of order 1/n. With
half a link's bending in series with that spring, 1/k = 1/k_T + l/(2 E I_a), the error is of order
1/n^2. All quantities are in SI units; ValueError is raised for arguments out of range.
"""

from __future__ import annotations

import math

import numpy as np

from bristle_sim.arrays import Array

RIGID = 1e-10
"""Ratio of root spring to bending stiffness, k_T L/(E I_a), below which the first mode is that of a
rigid rod.

The relative error is of the size of the ratio. The beam equation, a difference of order lambda^3,
would keep fewer digits."""


def second_moment_of_area(diameter: float) -> float:
    """Return the second moment of area of a round wire, pi d^4/64, in m^4.

    >>> print(f"{second_moment_of_area(2.0):.6f}")  # pi/4 of a radius of 1 m
    0.785398
    """
    return math.pi * diameter**4 / 64.0


def hinge_stiffness(diameter: float, length: float, modulus: float, links: int) -> float:
    """Return the torsion spring between two links of a wire, E I_a/l with l = L/n, in N m/rad.

    A wire of 2 m diameter, 4 m length and 1 Pa has E I_a = pi/4 N m^2; between two halves, l = 2 m:

    >>> print(f"{hinge_stiffness(2.0, 4.0, 1.0, 2):.6f}")
    0.392699
    """
    return modulus * second_moment_of_area(diameter) * links / length


def hinge_damping(
    mass: float,
    length: float,
    diameter: float,
    modulus: float,
    root_stiffness: float,
    damping_ratio: float,
    links: int,
) -> float:
    """Return the torsional damper between two links, 2 zeta k_w/omega_1, in N m s/rad.

    A damper proportional to the hinge's spring gives a mode of frequency omega the damping ratio
    zeta omega/omega_1. Here omega_1 is the frequency of the beam's first bending mode, and zeta the
    damping ratio of that mode.
    """
    first = beam_frequencies(mass, length, diameter, modulus, root_stiffness, 2)[1]
    return (
        2.0
        * damping_ratio
        * hinge_stiffness(diameter, length, modulus, links)
        / (math.tau * float(first))
    )


def beam_frequencies(
    mass: float, length: float, diameter: float, modulus: float, root_stiffness: float, modes: int
) -> Array:
    """Return the lowest natural frequencies of the beam, in Hz, shape (modes,).

    The first one is the swing of the wire on its root's spring (0 without one), the second the first bending mode.
    Mass in kg, length and diameter in m, Young's modulus in Pa, torsion spring at the root in N m/rad, 1 to 50 modes.

    The hinged beam's first bending mode has lambda = 3.926602; here E I_a/(m L^3) = 1, so that 2 pi f = lambda^2 = 15.4182:

    >>> frequencies = beam_frequencies(math.pi / 64.0, 1.0, 1.0, 1.0, 0.0, 2)
    >>> print(f"{math.tau * frequencies[1]:.4f}")
    15.4182
    """
    from scipy.optimize import (
        brentq,  # takes longer than everything else that a rigid bristle's scene imports
    )

    bending = modulus * second_moment_of_area(diameter)
    ratio = root_stiffness * length / bending

    def characteristic(wave: float) -> float:
        """Return the characteristic function of the beam, which is zero at the wave number of a
        mode."""
        # Divided by cosh(wave), which would overflow.
        inverse = 1.0 / math.cosh(wave)
        sine, cosine = math.sin(wave), math.cos(wave)
        return sine - cosine * math.tanh(wave) - ratio / wave * (inverse + cosine)

    # Each mode lies between that of the hinged beam, near (j - 3/4) pi, and that of the cantilever, near (j - 1/2) pi. The
    # first one is (3 ratio)^(1/4) for a small ratio, and at most the cantilever's 1.8751.
    low = min(1.0, 0.5 * (3.0 * ratio) ** 0.25)
    rigid = ratio < RIGID
    first = (
        math.sqrt(math.sqrt(3.0 * ratio))
        if rigid
        else brentq(characteristic, low, 1.9, xtol=1e-15 * low, rtol=1e-14)
    )
    waves = [
        brentq(characteristic, (j - 1) * math.pi, (j - 0.25) * math.pi, xtol=1e-15)
        for j in range(2, modes + 1)
    ]
    return np.array([first, *waves][:modes]) ** 2 * math.sqrt(bending / mass / length**3) / math.tau


def chain_frequencies(
    mass: float, length: float, diameter: float, modulus: float, root_stiffness: float, links: int
) -> Array:
    """Return the natural frequencies of the chain of equal rigid links at rest, in Hz, ascending, shape (links,).

    One link is a rod on its root's spring, 2 pi f = sqrt(k/(m L^2/3)) = 3 rad/s here:

    >>> print(f"{math.tau * chain_frequencies(1.0, 1.0, 0.1, 1.0, 3.0, 1)[0]:.6f}")
    3.000000
    """
    return chain_modes(mass, length, diameter, modulus, root_stiffness, links)[0]


def chain_modes(
    mass: float, length: float, diameter: float, modulus: float, root_stiffness: float, links: int
) -> tuple[Array, Array]:
    """Return the natural frequencies and the modes of the chain of links.

    The squares of 2 pi times the frequencies are the eigenvalues of the stiffness against the mass
    matrix in the links' absolute angles: M_jk = m l^2/n (n - max(j, k) + 1/2) off the diagonal (j,
    k from 1) and m l^2/n (n - j + 1/3) on it.

    Returns:
        The frequencies, Hz, ascending, shape (links,); and the angles of the links in each mode, by
        columns, shape (links, links).
    """
    from scipy.linalg import eigh

    each = mass / links
    link = length / links
    number = np.arange(1, links + 1)
    inertia = each * link**2 * (links - np.maximum.outer(number, number) + 0.5)
    np.fill_diagonal(inertia, each * link**2 * (links - number + 1.0 / 3.0))
    springs = np.full((links, 1), hinge_stiffness(diameter, length, modulus, links))
    springs[0] = root_stiffness
    twists = np.eye(links) - np.eye(links, k=-1)
    squares, shapes = eigh(twists.T @ (springs * twists), inertia)
    return np.asarray(np.sqrt(np.maximum(squares, 0.0)) / math.tau), np.asarray(shapes)
