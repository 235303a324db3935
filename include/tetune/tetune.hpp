// SPDX-License-Identifier: Apache-2.0
#pragma once

/// The whole public API.
#include "tetune/criteria.hpp"
#include "tetune/curve.hpp"
#include "tetune/curved.hpp"
#include "tetune/data.hpp"
#include "tetune/error.hpp"
#include "tetune/geometry.hpp"
#include "tetune/io.hpp"
#include "tetune/live_mesh.hpp"
#include "tetune/mesh.hpp"
#include "tetune/move.hpp"
#include "tetune/optimize.hpp"
#include "tetune/optimize_on_geometry.hpp"
#include "tetune/optimize_towards.hpp"
#include "tetune/option_table.hpp"
#include "tetune/periodic.hpp"
#include "tetune/quality.hpp"
#include "tetune/series.hpp"
#include "tetune/targets.hpp"
#include "tetune/validate.hpp"
#include "tetune/version.hpp"
