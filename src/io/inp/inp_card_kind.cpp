// SPDX-License-Identifier: Apache-2.0
#include "io/inp/inp_card_kind.hpp"

#include <algorithm>
#include <array>

namespace tetune {
namespace {

template <std::size_t N>
bool is_one_of(const std::string& name, const std::array<const char*, N>& names) {
  return std::any_of(names.begin(), names.end(), [&name](const char* n) { return name == n; });
}

constexpr const char* kGenerated =
    "this card generates parts of the mesh; let the program write a deck with all nodes and elements";

/// The data lines of these cards have neither nodes nor elements.
constexpr std::array kWithoutLabels{
    // Parts
    "ASSEMBLY", "ENDASSEMBLY", "ENDINSTANCE", "ENDPART", "INSTANCE", "PART",
    // Steps and output
    "AMPLITUDE", "BASEMOTION", "BUCKLE", "COMPLEXFREQUENCY", "CONTACTFILE", "CONTACTOUTPUT", "CONTACTPRINT", "CONTROLS",
    "COUPLEDTEMPERATURE-DISPLACEMENT", "DYNAMIC", "ELECTROMAGNETICS", "ELEMENTOUTPUT", "ELFILE", "ELPRINT", "ENDSTEP",
    "ENERGYFILE", "ENERGYOUTPUT", "ENERGYPRINT", "FACEPRINT", "FILEFORMAT", "FREQUENCY", "GEOSTATIC", "GREEN",
    "HEADING", "HEATTRANSFER", "MODALDAMPING", "MODALDYNAMIC", "MODALFILE", "MODALPRINT", "NODEFILE", "NODEOUTPUT",
    "NODEPRINT", "NOANALYSIS", "OUTPUT", "PARAMETER", "PREPRINT", "RESTART", "SECTIONPRINT", "SELECTEIGENMODES",
    "SENSITIVITY", "SOILS", "SOLUTIONTECHNIQUE", "SOLVERCONTROLS", "STATIC", "STEADYSTATEDYNAMICS", "STEP",
    "TIMEPOINTS", "UNCOUPLEDTEMPERATURE-DISPLACEMENT", "VALUESATINFINITY", "VISCO",
    // Materials
    "CONCRETEDAMAGEDPLASTICITY", "CONDUCTIVITY", "CREEP", "CYCLICHARDENING", "DAMAGEEVOLUTION", "DAMAGEINITIATION",
    "DAMPING", "DEFORMATIONPLASTICITY", "DENSITY", "DEPVAR", "DRUCKERPRAGER", "ELASTIC", "ELECTRICALCONDUCTIVITY",
    "EXPANSION", "FLUIDCONSTANTS", "HYPERELASTIC", "HYPERFOAM", "INELASTICHEATFRACTION", "JOULEHEATFRACTION",
    "LATENTHEAT", "MAGNETICPERMEABILITY", "MATERIAL", "MOHRCOULOMB", "PERMEABILITY", "PHYSICALCONSTANTS", "PLASTIC",
    "POROUSBULKMODULI", "POTENTIAL", "RATEDEPENDENT", "SPECIFICGASCONSTANT", "SPECIFICHEAT", "USERMATERIAL",
    "VISCOELASTIC", "VISCOSITY",
    // Sections and directions
    "BEAMGENERALSECTION", "BEAMSECTION", "CONNECTORBEHAVIOR", "CONNECTORELASTICITY", "CONNECTORSECTION", "DASHPOT",
    "FLUIDSECTION", "GAP", "HOURGLASSSTIFFNESS", "MASS", "MEMBRANESECTION", "ROTARYINERTIA", "SECTIONCONTROLS",
    "SHELLGENERALSECTION", "SHELLSECTION", "SOLIDSECTION", "SPRING", "TRANSFORM", "TRANSVERSESHEARSTIFFNESS",
    // Contact and coupling of surfaces
    "CHANGEFRICTION", "CONTACT", "CONTACTDAMPING", "CONTACTINCLUSIONS", "CONTACTPAIR", "CONTACTPROPERTYASSIGNMENT",
    "COUPLING", "DISTRIBUTING", "FRICTION", "GAPCONDUCTANCE", "GAPHEATGENERATION", "KINEMATIC", "SURFACEBEHAVIOR",
    "SURFACEINTERACTION", "TIE"};

using Fields = InpCardKind::Fields;

/// The kind of values that the lines of a card give nodes.
InpCardKind::Condition condition_of(const InpKeyword& keyword) {
  using Condition = InpCardKind::Condition;
  static constexpr std::array kFields{"TEMPERATURE", "FIELD", "NODALTHICKNESS", "PRESSURESTRESS"};
  static constexpr std::array kInitialFields{"TEMPERATURE", "FIELD", "PRESSURE"};
  static constexpr std::array kInitialComponents{"DISPLACEMENT", "VELOCITY", "FLUIDVELOCITY"};
  const std::string* type = keyword.find("TYPE");
  const std::string of = type == nullptr ? std::string() : inp_name(*type);
  if (is_one_of(keyword.name, kFields)) return Condition::field;
  if (keyword.name == "BOUNDARY") return Condition::range;
  if (keyword.name == "SURFACE" && of == "NODE") return Condition::members;
  if (keyword.name != "INITIALCONDITIONS") return Condition::none;
  if (is_one_of(of, kInitialFields)) return Condition::field;
  return is_one_of(of, kInitialComponents) ? Condition::components : Condition::none;
}

/// The fields of cards with special syntax, or of one that is not known.
void find_fields(const InpKeyword& keyword, InpCardKind& kind) {
  static constexpr std::array kOfNodes{"BOUNDARY",          "CLOAD", "CFLUX",     "TEMPERATURE",      "NODALTHICKNESS",
                                       "RETAINEDNODALDOFS", "FIELD", "BOUNDARYF", "CONCENTRATEDFLUX", "MASSFLOWRATE",
                                       "PRESSURESTRESS"};
  static constexpr std::array kPerNode{"CLOAD", "CFLUX",    "CONCENTRATEDFLUX", "CFILM",
                                       "CFLOW", "CRADIATE", "CECHARGE",         "CECURRENT"};
  static constexpr std::array kOfElementConditions{"STRESS", "PLASTICSTRAIN", "SOLUTION", "HARDENING"};
  const std::string& name = keyword.name;
  const std::string* type = keyword.find("TYPE");
  if (is_one_of(name, kWithoutLabels)) return;
  kind.nodes = kind.elements = Fields::first;
  if (is_one_of(name, kOfNodes)) kind.elements = Fields::none;
  kind.is_per_node = is_one_of(name, kPerNode);
  if (kind.has_faces) kind.nodes = Fields::none;
  if (name == "MODELCHANGE") kind = {Fields::none, Fields::every};
  if (name == "SUBMODEL") kind = {Fields::every, Fields::none};
  if (name == "ORIENTATION") {
    const std::string* definition = keyword.find("DEFINITION");
    const bool has_nodes = definition != nullptr && inp_name(*definition) == "NODES";
    kind = {has_nodes ? Fields::every : Fields::none, Fields::none};
  }
  if (name == "MPC" || name == "EQUATION") {
    kind = {name == "MPC" ? Fields::every : Fields::every_third, Fields::none};
    kind.pairs = true;
  }
  if (name == "INITIALCONDITIONS") {
    const bool of_elements = type != nullptr && is_one_of(inp_name(*type), kOfElementConditions);
    (of_elements ? kind.nodes : kind.elements) = Fields::none;
  }
  if (name == "SURFACE" && !kind.has_faces) {
    const bool of_nodes = type != nullptr && inp_name(*type) == "NODE";
    kind = {of_nodes ? Fields::first : Fields::none, Fields::none};
  }
}

}  // namespace

InpCardKind inp_card_kind(const InpKeyword& keyword) {
  static constexpr std::array kGenerators{"NGEN", "NFILL", "NCOPY", "NMAP", "ELGEN", "ELCOPY"};
  static constexpr std::array kOnFaces{"DLOAD", "DFLUX",    "FILM",      "RADIATE",   "FOUNDATION", "FLOW",
                                       "DFLOW", "DECHARGE", "DECURRENT", "IMPEDANCE", "MASSFLOW"};
  InpCardKind kind;
  const std::string& name = keyword.name;
  if (is_one_of(name, kGenerators)) kind.refusal = kGenerated;
  if (name == "SYSTEM") kind.refusal = "tetune does not read coordinates in another system";
  if (kind.refusal != nullptr) return kind;
  kind.has_faces = is_one_of(name, kOnFaces);
  if (name == "SURFACE") {
    const std::string* type = keyword.find("TYPE");
    const bool of_elements = type == nullptr || inp_name(*type) == "ELEMENT";
    kind.has_faces = of_elements && !keyword.has("COMBINE") && !keyword.has("CROP");
  }
  find_fields(keyword, kind);
  kind.condition = condition_of(keyword);
  return kind;
}

}  // namespace tetune
