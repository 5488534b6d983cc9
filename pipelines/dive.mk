# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
#
# One dive, step by step:   make -f pipelines/dive.mk PACKAGE=dives/dive-a RUNS=runs -j 2
#
# Every step is a rule on its manifest.json, so that a rule of yours may depend on one. Steps that a dive cannot have (no camera,
# no sonar) have no rule. A dive has one writer at a time: steps that -j starts together queue. `hullrecon run` does the same
# in one process; this file is for those who join the chain with other tools.

RUNS ?= runs
HULLRECON ?= hullrecon
WAIT_S ?= 86400

ifndef PACKAGE
$(error give PACKAGE=folder of the dive package)
endif

# The dive's name in dive.toml is that of its folder in RUNS.
NAME := $(shell sed -n "/^\[dive\]/,/^\[[^d]/s/^name *= *[\"']\([^\"']*\).*/\1/p" $(PACKAGE)/dive.toml)
RUN := $(RUNS)/$(NAME)
STEPS := $(shell $(HULLRECON) status $(PACKAGE) --runs $(RUNS) | awk '$$2 !~ /^skipped/ {print $$1}')
ifeq ($(and $(NAME),$(STEPS)),)
$(error $(PACKAGE) is no dive package that can be run)
endif

manifests = $(patsubst %,$(RUN)/%/manifest.json,$(filter $(STEPS),$(1)))

.PHONY: all
all: $(call manifests,$(STEPS))

# `hullrecon STEP` leaves a step alone whose inputs changed in their times only: touch tells make so.
$(call manifests,$(STEPS)): $(RUN)/%/manifest.json: $(PACKAGE)/dive.toml
	@$(HULLRECON) --quiet $* $(PACKAGE) --runs $(RUNS) --wait $(WAIT_S)
	@touch -c $@

# Which step takes which; tests/pipelines holds this to the steps' own declarations.
LOG_FILES := $(shell find $(PACKAGE) -type f ! -name dive.toml ! -path '*/truth/*')
$(call manifests,ingest): $(LOG_FILES)
$(call manifests,navigate features): $(call manifests,ingest)
$(call manifests,matches): $(call manifests,ingest navigate features)
$(call manifests,adjust): $(call manifests,ingest navigate matches)
$(call manifests,surface): $(call manifests,ingest navigate adjust)
$(call manifests,detect): $(call manifests,ingest adjust surface)
$(call manifests,mosaic-optical mosaic-sonar): $(call manifests,ingest navigate adjust surface detect)
$(call manifests,report): $(call manifests,$(filter-out report,$(STEPS)))
