# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""One thread for BLAS, as the commands have it: its threads wait by spinning, and a test took two minutes instead of six
seconds beside another process. Set here, before anything imports numpy, for a pytest that is called by itself."""

import os

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
os.environ.setdefault("OMP_NUM_THREADS", "1")
