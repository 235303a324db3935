// SPDX-License-Identifier: Apache-2.0
#pragma once

#define TETUNE_VERSION_MAJOR 0
#define TETUNE_VERSION_MINOR 1
#define TETUNE_VERSION_PATCH 0
#define TETUNE_VERSION "0.1.0"
