#!/usr/bin/env -S python
# /// script
# dependencies = ["nox>=2024.10.9"]
# ///
"""Tasks of a developer, each in its own virtual environment: ``nox`` checks and tests, ``nox -l`` lists all."""

import random
from collections import Counter, defaultdict

import nox

LEAST_NOTICED = 0.93  # fraction of mutmut's changes that tests must notice; the rest changes words, effort or nothing

nox.needs_version = ">=2024.10.9"
nox.options.default_venv_backend = "uv|virtualenv"


@nox.session
def lint(session: nox.Session) -> None:
    """Check style, formatting and types."""
    session.install("-e", ".[test]")
    session.run("ruff", "check")
    session.run("ruff", "format", "--check")
    session.run("mypy")


@nox.session(python=["3.11", "3.12", "3.13", "3.14"])
def tests(session: nox.Session) -> None:
    """Run the tests; arguments after ``--`` go to pytest."""
    session.install("-e", ".[test]")
    session.run("pytest", *session.posargs)


@nox.session(default=False)
def coverage(session: nox.Session) -> None:
    """Run the tests with every peer, and print the branches that no test takes."""
    session.install("-e", ".[test,peers]", "playwright", "slipcover")
    session.run("python", "-W", "ignore", "-m", "slipcover", "-m", "pytest", *session.posargs)


@nox.session(python="3.11", default=False)
def minimum(session: nox.Session) -> None:
    """Run the tests with the oldest versions of the libraries that pyproject.toml admits."""
    session.install("-e", ".[test]", "-c", "minimum-versions.txt")
    session.run("pytest", *session.posargs)


@nox.session(default=False)
def docs(session: nox.Session) -> None:
    """Build the site with warnings as errors; every example on it runs."""
    session.install("-e", ".[docs]")
    session.run("python", "-m", "sphinx", "-W", "--keep-going", "-b", "html", "docs", "build/docs")


@nox.session(default=False)
def nightly(session: nox.Session) -> None:
    """Run the long tests, with every peer: long wires, random tools, every figure; build the site and its kept results anew.

    All other tests run with fresh examples in a random order, and with the linear algebra of two older processors.
    """
    session.install("-e", ".[docs,sweep,test,peers]", "playwright")
    session.run("pytest", "-m", "nightly", *session.posargs)
    seed = str(random.randrange(10**6))
    session.run(
        "pytest", "--random-order", seed, *session.posargs, env={"BRISTLE_FRESH_EXAMPLES": "1"}
    )
    for processor in ("Haswell", "Nehalem"):  # the results of overflow differ too
        session.run("pytest", *session.posargs, env={"OPENBLAS_CORETYPE": processor})
    session.run("python", "docs/keep.py")
    docs(session)


@nox.session(default=False)
def mutants(session: nox.Session) -> None:
    """Change the physics in every way that mutmut knows; print the survivors and, by module, the changes that tests notice; hours.

    Arguments after ``--`` are patterns of names, such as ``"bristle_sim.theory.cueing*"``.
    """
    session.install("-e", ".[test]", "mutmut>=3.3")
    session.run("mutmut", "run", *session.posargs)
    modules: dict[str, Counter[str]] = defaultdict(Counter)
    for line in str(session.run("mutmut", "results", "--all", "true", silent=True)).splitlines():
        name, _, status = line.strip().rpartition(": ")
        if name and status != "not checked":
            modules[name.rpartition(".")[0]][status] += 1
            if status in ("survived", "no tests", "suspicious"):
                session.log(f"{status}: {name}")
    for module, found in sorted(modules.items()):
        session.log(
            f"{found['killed'] + found['timeout']:5} of {found.total():5} noticed: {module}"
        )
    noticed = sum(found["killed"] + found["timeout"] for found in modules.values())
    changes = sum(found.total() for found in modules.values())
    if noticed < LEAST_NOTICED * changes:
        session.error(
            f"{noticed} of {changes} changes are noticed; must be at least {LEAST_NOTICED:.0%}"
        )


@nox.session(default=False)
def package(session: nox.Session) -> None:
    """Build the source distribution and the wheel, and check both."""
    session.install("build", "check-wheel-contents", "validate-pyproject[all]")
    session.run("validate-pyproject", "pyproject.toml")
    session.run("python", "-m", "build", "--outdir", session.create_tmp())
    session.run("check-wheel-contents", session.create_tmp())


if __name__ == "__main__":
    nox.main()
