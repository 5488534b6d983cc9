# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""What the sources hold, part by part, and where it is here."""

from hullrecon.studies.catalogue.aulinas import AULINAS
from hullrecon.studies.catalogue.kim import KIM
from hullrecon.studies.catalogue.ozog import OZOG
from hullrecon.studies.catalogue.part import Absence, Part, Source, Status

SOURCES = (OZOG, AULINAS, KIM)

__all__ = ["SOURCES", "Absence", "Part", "Source", "Status"]
