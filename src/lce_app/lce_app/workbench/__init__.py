# SPDX-License-Identifier: Apache-2.0
"""`lce workbench`: a local web page over the use cases that the commands call, without logic of its own.

session.py           what the user decided, in files beside the runs
state.py             what all open pages share
jobs.py, tasks.py    long work, in a process of its own
records.py, kept_blocks.py    what that work leaves for the page
texts.py             headings, code and names, which files may fill with anything
topic_monitor.py, topic_monitor_node.py, snapshot.py    the topics of the bench, live
drawings.py, figures.py    blocks of the report, drawn on the page
page.py, tabs/       the page
server.py, guard.py  the server, and who may talk to it
early_reading.py, quick_imports.py    what makes it start sooner

The page comes before the physics: what it needs at first imports lce_model and lce_analysis within its functions, as
that takes a second or two.
"""
