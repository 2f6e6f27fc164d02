"""What counts as a continuous force law of a contact."""

from lcpflex.contact.laws.contact_law import ContactLaw
from lcpflex.contact.penalty import Penalty

__all__ = ["Law"]

Law = ContactLaw | Penalty
