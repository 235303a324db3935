# SPDX-License-Identifier: Apache-2.0
"""One self-contained page that shows a mesh before and after: `tetune report`, `tetune optimize --report-html`."""

from ._page import write_page

__all__ = ["write_page"]
