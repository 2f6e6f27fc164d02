"""What counts as a continuous force law of a contact."""

from lcpflex.force_laws.contact_law import ContactLaw
from lcpflex.force_laws.penalty import Penalty

__all__ = ["Law"]

Law = ContactLaw | Penalty
