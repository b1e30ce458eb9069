"""One impact of a chain of rods, simulated by every contact law."""

from dataclasses import dataclass

from bristle_sim.parameters import Contact, Surface
from bristle_sim.scene.strike import Chain, ChainStrike, strike
from bristle_sim.settings import Settings

LAWS = ("energetic", "compliant", "engine")


@dataclass(frozen=True, slots=True)
class Impacts:
    """One impact of a chain of rods on a surface, computed by every contact law.

    Attributes:
        chain: the rods before the impact.
        surface: the surface.
        contact: the contact law that the user requested, with its parameters.
        strikes: simulated impact by each contact law, by the name of the law.
        refusals: reason why a law cannot compute the impact, by the name of the law.
        timing: sentence that states how the duration of a contact resolved in time was chosen.
    """

    chain: Chain
    surface: Surface
    contact: Contact
    strikes: dict[str, ChainStrike]
    refusals: dict[str, str]
    timing: str


def all_laws(chain: Chain, surface: Surface, contact: Contact, settings: Settings) -> Impacts:
    """Simulate an impact by the requested contact law, and by every other law that can compute it.

    Raises:
        ValueError: if the requested law cannot compute the impact, or a rod turns too slowly to be
            distinguished from rest.
    """
    strikes = dict[str, ChainStrike]()
    refusals = dict[str, str]()
    for law in LAWS:
        elastic = 0.0 if law == "engine" else contact.tangential_compliance
        other = Contact(law, tangential_compliance=elastic)
        try:
            strikes[law] = strike(
                chain, surface, contact if law == contact.law else other, settings
            )
        except ValueError as error:
            if law == contact.law:
                raise
            refusals[law] = str(error)
    timing = "rigid-body limit" if contact.duration is None else "contact_duration as requested"
    return Impacts(chain, surface, contact, strikes, refusals, timing)
