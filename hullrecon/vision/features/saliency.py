# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""How much there is to recognise in one image [KimEustice2013; Ozog2016 2.3.3]: the entropy of its
bag of words.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

BITS = 8
# of the planes that cut descriptor space into words; any one does, but always the same
_SEED = 20130629


def local_saliency(descriptors: NDArray[np.uint8]) -> float:
    """Return the entropy of the words of (n, 128) descriptors over its largest: 0 none or all
    alike, 1 all words as frequent.

    The vocabulary is not learnt: eight random planes through the middle of descriptor space make
    256 words, so that one image's score depends on no other image.
    """
    if len(descriptors) == 0:
        return 0.0
    planes = (
        np.random.default_rng(_SEED)
        .standard_normal((descriptors.shape[1], BITS))
        .astype(np.float32)
    )
    # descriptors are positive: their common part must not decide the side
    planes -= planes.mean(axis=0)
    words = (descriptors.astype(np.float32) @ planes > 0) @ (1 << np.arange(BITS))
    share = np.bincount(words, minlength=1 << BITS) / len(descriptors)
    share = share[share > 0]
    return max(0.0, float(-(share * np.log2(share)).sum() / BITS))
