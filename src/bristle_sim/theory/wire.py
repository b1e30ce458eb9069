"""Bending of a wire on a torsion spring at its root: natural frequencies of the beam, and of the
chain of rigid links that approximates it.

The beam is a uniform Euler-Bernoulli beam of length L, mass m and bending stiffness E I_a. Its root
is hinged on a torsion spring k_T, and its other end is free. The beam vibrates at omega = lambda^2
sqrt(E I_a/(m L^3)), where lambda solves

    sin(lambda) cosh(lambda) - cos(lambda) sinh(lambda)
        = (k_T L/(E I_a)) (1 + cos(lambda) cosh(lambda))/lambda.

Without the spring (a hinged beam) this equation is tan(lambda) = tanh(lambda). With a rigid spring
the beam is a cantilever.

The chain consists of n equal rigid links of length l = L/n and mass m/n, hinged end to end with the
torsion spring E I_a/l in each hinge. Unlike the beam, the chain does not bend at the root, because
its first link is rigid. With the root spring k_T the error of the chain's frequencies is therefore
of order 1/n. If the bending compliance of half a link is added to that of the root spring,
1/k = 1/k_T + l/(2 E I_a), the error is of order 1/n^2. All quantities are in SI units.
"""

from __future__ import annotations

import math

import numpy as np

from bristle_sim.arrays import Array

RIGID = 1e-10
"""Ratio k_T L/(E I_a) of the root spring's stiffness to the bending stiffness, below which the
first mode is computed as for a rigid rod.

The relative error is about as large as this ratio. The characteristic equation of the beam, a
difference of order lambda^3, would lose more digits."""


def second_moment_of_area(diameter: float) -> float:
    """Return the second moment of area pi d^4/64 of a round wire of diameter d, m^4.

    For a diameter of 2 m it is pi/4:

    >>> print(f"{second_moment_of_area(2.0):.6f}")
    0.785398
    """
    return math.pi * diameter**4 / 64.0


def hinge_stiffness(diameter: float, length: float, modulus: float, links: int) -> float:
    """Return the stiffness of the torsion spring between two rigid links of a wire, N m/rad.

    The stiffness is E I_a/l, with Young's modulus E, the second moment of area I_a, and the length
    l of a link. l is the wire's length divided by the number of links.

    A wire of 2 m diameter, 4 m length and 1 Pa has E I_a = pi/4 N m^2; its two links are 2 m long:

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
    """Return the constant of the torsional damper between two rigid links of a wire, N m s/rad.

    The constant is 2 zeta k_w/omega_1, where k_w is the stiffness of ``hinge_stiffness``. zeta
    (``damping_ratio``) is the damping ratio of the beam's first bending mode, and omega_1 the
    angular frequency of this mode. A mode of angular frequency omega then has the damping ratio
    zeta omega/omega_1. A wire without bending stiffness has no damping. The other arguments are
    those of ``beam_frequencies``.
    """
    stiffness = hinge_stiffness(diameter, length, modulus, links)
    if not (damping_ratio and stiffness):
        return 0.0
    first = beam_frequencies(mass, length, diameter, modulus, root_stiffness, 2)[1]
    return 2.0 * damping_ratio * stiffness / (math.tau * float(first))


def beam_frequencies(
    mass: float, length: float, diameter: float, modulus: float, root_stiffness: float, modes: int
) -> Array:
    """Return the lowest natural frequencies of a wire as a beam (Hz), shape (modes,).

    The root of the wire is hinged on a torsion spring, and its other end is free. In the first mode
    the wire swings on the spring; without the spring the frequency is 0. The second mode is the
    first bending mode.

    Args:
        mass: mass of the wire, kg.
        length: length of the wire, m.
        diameter: diameter of the wire, m.
        modulus: Young's modulus, Pa.
        root_stiffness: stiffness of the torsion spring at the root, N m/rad.
        modes: number of modes, 1 to 50.

    Without the spring the first bending mode has the wave number lambda = 3.926602. Here E I_a/(m
    L^3) = 1, so that the angular frequency is lambda^2 = 15.4182 rad/s:

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
        """Return the characteristic function, whose roots are the modes' wave numbers lambda."""
        # Divided by cosh(wave), which would overflow.
        inverse = 1.0 / math.cosh(wave)
        sine, cosine = math.sin(wave), math.cos(wave)
        return sine - cosine * math.tanh(wave) - ratio / wave * (inverse + cosine)

    # Each mode lies between that of the hinged beam, near (j - 3/4) pi, and that of the cantilever,
    # near (j - 1/2) pi. The first one is (3 ratio)^(1/4) for a small ratio, and at most the
    # cantilever's 1.8751.
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
    """Return the natural frequencies of a chain of equal rigid links (Hz), in ascending order.

    The chain approximates a wire. The arguments are those of ``beam_frequencies``, with the number
    of links instead of modes. The result has the shape (links,).

    The squared angular frequencies are the generalised eigenvalues of the stiffness and mass
    matrices in the links' absolute angles. For n links of length l and mass m_l the mass matrix is
    M_jk = m_l l^2 (n - max(j, k) + 1/2) for j != k, and M_jj = m_l l^2 (n - j + 1/3), with j and k
    from 1 to n.

    One link is a rigid rod on the spring at its root, here with the angular frequency sqrt(k/(m
    L^2/3)) = 3 rad/s:

    >>> print(f"{math.tau * chain_frequencies(1.0, 1.0, 0.1, 1.0, 3.0, 1)[0]:.6f}")
    3.000000
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
    squares = eigh(twists.T @ (springs * twists), inertia, eigvals_only=True)
    return np.asarray(np.sqrt(np.maximum(squares, 0.0)) / math.tau)
