# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
#
# One dive, step by step:   make -f pipelines/dive.mk PACKAGE=dives/dive-a RUNS=runs -j 2
#
# Every step is a rule on its manifest.json, so that a rule of yours may depend on one. Steps that a dive cannot have (no camera,
# no sonar) have no rule. A dive has one writer at a time: steps that -j starts together queue. `hullrecon run` does the same
# in one process, `hullrecon fleet` for a folder of dives; this file is for those who join the chain with other tools.
#
# PACKAGE may be any path, and its files may have any names: make sees neither. RUNS must have no spaces.

RUNS ?= runs
HULLRECON ?= hullrecon
WAIT_S ?= 86400

ifndef PACKAGE
$(error give PACKAGE=folder of the dive package)
endif
ifneq ($(words $(RUNS)),1)
$(error RUNS=$(RUNS) has spaces, which make cannot have in the names of its targets)
endif

# As it was given, never expanded; and in quotes for the shell.
override PACKAGE := $(value PACKAGE)
PACKAGE_QUOTED := '$(subst ','\'',$(PACKAGE))'

# "dive=NAME", "rerun=change" and the steps that this dive has, as hullrecon reads dive.toml; a name has letters, digits, '.', '_' and '-' only.
FOUND := $(shell $(HULLRECON) --json status $(PACKAGE_QUOTED) --runs $(RUNS) | awk -F'"' \
	'/^ "dive":/ {print "dive=" $$4} /^   "name":/ {name = $$4} /^   "state":/ && $$4 != "skipped" {print name} \
	/^   "state":/ && $$4 == "out of date" && name == "change" {print "rerun=change"}')
NAME := $(patsubst dive=%,%,$(filter dive=%,$(FOUND)))
RUN := $(RUNS)/$(NAME)
STEPS := $(filter-out dive=% rerun=%,$(FOUND))
ifeq ($(and $(NAME),$(STEPS)),)
$(error $(PACKAGE) is no dive package that can be run)
endif

manifests = $(patsubst %,$(RUN)/%/manifest.json,$(filter $(STEPS),$(1)))

.PHONY: all changed
all: $(call manifests,$(STEPS))

# `hullrecon STEP` leaves a step alone whose inputs changed in their times only: touch tells make so.
$(call manifests,$(STEPS)): $(RUN)/%/manifest.json:
	@$(HULLRECON) --quiet $* $(PACKAGE_QUOTED) --runs $(RUNS) --wait $(WAIT_S)
	@touch -c $@

# A step whose manifest is older than dive.toml has to be looked at, ingest also if any other file of the package is newer, change
# where it is out of date: what else it takes is the run of an earlier dive, which make does not see.
OLDER := $(foreach step,$(STEPS),$(shell [ $(PACKAGE_QUOTED)/dive.toml -nt $(RUN)/$(step)/manifest.json ] && echo $(step)))
NEWER := $(shell find $(PACKAGE_QUOTED) -type f ! -path '*/truth/*' -newer $(RUN)/ingest/manifest.json 2>/dev/null | head -n 1)
ifneq ($(OLDER),)
$(call manifests,$(OLDER)): changed
endif
ifneq ($(NEWER),)
$(call manifests,ingest): changed
endif
ifneq ($(filter rerun=change,$(FOUND)),)
$(call manifests,change): changed
endif
changed:

# Which step takes which; tests/pipelines holds this to the steps' own declarations.
$(call manifests,navigate features): $(call manifests,ingest)
$(call manifests,links): $(call manifests,ingest navigate features)
$(call manifests,matches): $(call manifests,ingest navigate features links)
$(call manifests,adjust): $(call manifests,ingest navigate links matches)
$(call manifests,surface): $(call manifests,ingest navigate adjust)
$(call manifests,detect): $(call manifests,ingest adjust surface)
$(call manifests,change): $(call manifests,ingest adjust surface detect)
$(call manifests,mosaic-optical mosaic-sonar): $(call manifests,ingest navigate adjust surface detect)
$(call manifests,report): $(call manifests,$(filter-out report,$(STEPS)))
