# SPDX-License-Identifier: Apache-2.0
import signal

# Jobs in the background of a shell ignore it, and Python then leaves it so.
signal.signal(signal.SIGINT, signal.default_int_handler)
