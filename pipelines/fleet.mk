# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
#
# All dives of a folder:   make -f pipelines/fleet.mk DIVES=dives RUNS=runs -k -j 2
#
# A dive is every folder below DIVES that holds a dive.toml. What is new or stale is run, the rest left alone; -k goes on with
# the next dive when one fails, and make then ends with code 2. Each run's log lies in RUNS/logs. Silent when all is well.

DIVES ?= dives
RUNS ?= runs
HULLRECON ?= hullrecon

PACKAGES := $(patsubst %/dive.toml,%,$(sort $(wildcard $(DIVES)/*/dive.toml)))
name_of = $(shell sed -n "/^\[dive\]/,/^\[[^d]/s/^name *= *[\"']\([^\"']*\).*/\1/p" $(1)/dive.toml)
NAMES := $(foreach package,$(PACKAGES),$(call name_of,$(package)))
ifneq ($(words $(NAMES)),$(words $(sort $(NAMES))))
$(error two dives below $(DIVES) have the same name: $(NAMES))
endif

.PHONY: all
all:

# One rule a dive: its last step's manifest, remade by `run`, which looks at contents where make looks at times.
define dive
all: $(RUNS)/$(2)/report/manifest.json
$(RUNS)/$(2)/report/manifest.json: $(shell find $(1) -type f ! -path '*/truth/*') | $(RUNS)/logs
	@$(HULLRECON) --quiet run $(1) --runs $(RUNS) --log-file $(RUNS)/logs/$(2).log
	@touch -c $$@
endef
$(foreach package,$(PACKAGES),$(eval $(call dive,$(package),$(call name_of,$(package)))))

$(RUNS)/logs:
	@mkdir -p $@
