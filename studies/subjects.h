// The subjects of `kappamu-studies`, each made where its sections are.
#pragma once

#include "studies/subject.h"

namespace kappamu::studies {

Subject boundary_subject();
Subject devices_subject();
Subject dipole_subject();
Subject figures_subject();
Subject forward_subject();
Subject fur_subject();
Subject hdr_subject();
Subject inverse_subject();
Subject limits_subject();
Subject objects_subject();
Subject photographs_subject();
Subject polygrid_subject();
Subject rig_subject();
Subject sfdi_subject();
Subject slabs_subject();
Subject uncertainty_subject();
Subject validity_subject();
Subject views_subject();

}  // namespace kappamu::studies
