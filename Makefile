# SPDX-License-Identifier: Apache-2.0
# For any x86-64 Linux with Python 3.11 or 3.12 and a C++ compiler. On Ubuntu with apt's ROS 2 Jazzy use colcon (README).
RUN := tools/env.sh
.DEFAULT_GOAL := help
.PHONY: help setup build demo test lint format docs pictures tables hidden hidden-heat peer discovery days heater comparison control faults interrupts fuzz bench lock clean

help:  ## this list
	@sed -nE 's/^([a-z-]+):[^#]*## /\1\t/p' Makefile | expand -t 13

setup:  ## .venv with ROS 2 Jazzy and all tools, workspace built (the others call it)
	@tools/setup.sh

build:  ## build the workspace again, as after a new entry point
	@tools/setup.sh --build

demo: setup  ## a strip with a hidden effect: recorded, fitted, compared, diagnosed, mended
	@$(RUN) python -m lce_app.demo

test: setup  ## every test (one of them: tools/env.sh pytest -k NAME)
	@$(RUN) tools/test.sh

lint: setup  ## ruff, mypy, the import contract, plain English, hadolint, schemas of compose files and the citation
	@$(RUN) tools/lint.sh

format: setup  ## ruff's formatter and its safe fixes
	@$(RUN) bash -c 'ruff format . && ruff check --fix .'

docs: setup  ## the documents as a site in site/, which needs no network
	@$(RUN) tools/docs.sh

pictures: setup  ## the demo's output for the documents, and pictures of its reports
	@$(RUN) python -m lce_app.demo > docs/tutorials/first-hour-output.txt
	@$(RUN) python tools/pictures.py
	@LCE_SCREENSHOTS=$(CURDIR)/docs/pictures/tour $(RUN) pytest -q -p no:xdist test/system/test_first_minutes_in_chromium.py

tables: setup  ## the dissertation's tables beside ours
	@$(RUN) python validation/tables.py

hidden: setup  ## the diagnosis on strips that hide an effect (hours; HIDDEN="--minutes 30")
	@$(RUN) python validation/hidden/suite.py --first-seed 12 --out docs/results/hidden.md $(HIDDEN)

hidden-heat: setup  ## the same on the heat alone, which takes seconds a case (half an hour; HIDDEN="--seeds 2")
	@$(RUN) python validation/hidden/suite.py --first-seed 7 --families equilibrium-heat chapter-5-continuous-heat relays-heat \
		independent-heat --results docs/results/hidden-heat-results.jsonl --out docs/results/hidden-heat.md $(HIDDEN)

peer: setup  ## petab-select on cases of hidden-heat, shown by the next make hidden-heat (150 MB; an hour; PEER="--minutes 20")
	@$(RUN) pip install --quiet --no-deps -r requirements/peer.txt
	@$(RUN) python validation/hidden/peer.py --first-seed 7 --families equilibrium-heat chapter-5-continuous-heat relays-heat \
		independent-heat --minutes 60 $(PEER)

discovery: setup  ## what no library holds, on strips that hide it (hours; DISCOVERY="--minutes 30")
	@$(RUN) python validation/hidden/discovery.py --out docs/results/discovery-results.md $(DISCOVERY)

days: setup  ## campaigns of ten runs that differ from day to day (an hour; DAYS="--seeds 1 --minutes 10")
	@$(RUN) python validation/days.py --out docs/results/days.md $(DAYS)

heater: setup  ## the diagnosis on every split of a measured heater's runs (3 minutes; HEATER="--source FOLDER")
	@$(RUN) python validation/heater_splits.py --out docs/results/heater-splits.md $(HEATER)

comparison: setup  ## the deformation models beside each other, on seen and unseen runs
	@$(RUN) python validation/comparison.py

control: setup  ## the modes of control beside each other and the bang-bang limit (10 minutes)
	@$(RUN) python validation/control_comparison.py

faults: setup  ## time to dark of every fault, on real processes and an emulated LabJack (an hour)
	@$(RUN) python validation/faults/suite.py --out docs/results/faults.md $(FAULTS)

interrupts: setup  ## Ctrl-C at 100 random moments of a start, and no traceback (5 minutes; INTERRUPTS="--seed 2")
	@$(RUN) python validation/interrupts.py $(INTERRUPTS)

fuzz: setup  ## 2000 damaged and hostile files, and what lce says of each (10 minutes; FUZZ="--cases 200 --seed 2")
	@$(RUN) python validation/fuzz.py --out docs/results/fuzz.md $(FUZZ)

bench: setup  ## speed, latency, jitter
	@$(RUN) python benchmarks/run.py

lock:  ## resolve requirements/venv.in anew (needs Python 3.11)
	@python3.11 tools/lock.py

clean:  ## remove what setup and build made
	@rm -rf .venv build install log
