# SPDX-License-Identifier: Apache-2.0
"""What a user can do, a module each: plain arguments and frozen options in, files and a frozen result out.

The commands of `lce` parse and print, the pages of the workbench draw; both call these functions. Each raises LceError
for data or a model that cannot be used, and writes its files whole and last.

All but `simulate` and `try_effect`, which are done at once, take ``progress``
(:class:`lce_data.progress.Progress`) and ``cancel`` (:class:`lce_data.progress.CancelToken`).
"""
