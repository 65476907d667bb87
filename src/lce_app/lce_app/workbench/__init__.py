# SPDX-License-Identifier: Apache-2.0
"""`lce workbench`: a local web page over the library that the other commands call, without logic of its own.

session.py  what the user decided, in files beside the runs   jobs.py, work.py  long work, in a process of its own
bench.py    what all open pages share                         live.py, live_node.py, heard.py  the topics, heard live
figures.py  blocks of the report, drawn on the page           page.py, tabs/    the page
server.py   the server, guard.py who may talk to it

The page comes before the physics: what it needs at first imports lce_model and lce_analysis within its functions, as
that takes a second or two.
"""
