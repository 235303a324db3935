// SPDX-License-Identifier: Apache-2.0
// Writes the CAD files of tests/cli/test_geometry.py to a folder: make_parts FOLDER
#include <BRepAlgoAPI_BuilderAlgo.hxx>
#include <BRepBuilderAPI_MakeEdge.hxx>
#include <BRepBuilderAPI_MakeFace.hxx>
#include <BRepBuilderAPI_MakeWire.hxx>
#include <BRepPrimAPI_MakeBox.hxx>
#include <BRepPrimAPI_MakeCylinder.hxx>
#include <BRepPrimAPI_MakePrism.hxx>
#include <BRepPrimAPI_MakeSphere.hxx>
#include <BRepTools.hxx>
#include <GeomAPI_Interpolate.hxx>
#include <Geom_BSplineCurve.hxx>
#include <IGESControl_Writer.hxx>
#include <Interface_Static.hxx>
#include <STEPControl_Controller.hxx>
#include <STEPControl_Writer.hxx>
#include <TColgp_HArray1OfPnt.hxx>
#include <TopTools_ListOfShape.hxx>
#include <cmath>
#include <numbers>
#include <string>

namespace {

/// A prism over a closed spline through points of r = 1 + 0.2 cos(3 t).
TopoDS_Shape spline_prism() {
  constexpr int kPoints = 24;
  const Handle(TColgp_HArray1OfPnt) points = new TColgp_HArray1OfPnt(1, kPoints);
  for (int i = 0; i < kPoints; ++i) {
    const double t = 2 * std::numbers::pi * i / kPoints;
    const double r = 1 + 0.2 * std::cos(3 * t);
    points->SetValue(i + 1, gp_Pnt(r * std::cos(t), r * std::sin(t), 0));
  }
  GeomAPI_Interpolate curve(points, Standard_True, 1e-9);
  curve.Perform();
  BRepBuilderAPI_MakeWire wire(BRepBuilderAPI_MakeEdge(curve.Curve()).Edge());
  return BRepPrimAPI_MakePrism(BRepBuilderAPI_MakeFace(wire.Wire()).Face(), gp_Vec(0, 0, 1)).Shape();
}

/// Two boxes with a common face.
TopoDS_Shape boxes() {
  TopTools_ListOfShape parts;
  parts.Append(BRepPrimAPI_MakeBox(gp_Pnt(0, 0, 0), gp_Pnt(0.5, 1, 1)).Shape());
  parts.Append(BRepPrimAPI_MakeBox(gp_Pnt(0.5, 0, 0), gp_Pnt(1, 1, 1)).Shape());
  BRepAlgoAPI_BuilderAlgo fuse;
  fuse.SetArguments(parts);
  fuse.Build();
  return fuse.Shape();
}

bool write_step(const TopoDS_Shape& shape, const std::string& file, const char* unit = "MM") {
  STEPControl_Controller::Init();  // defines the parameter
  Interface_Static::SetCVal("write.step.unit", unit);
  STEPControl_Writer writer;
  return writer.Transfer(shape, STEPControl_AsIs) == IFSelect_RetDone && writer.Write(file.c_str()) == IFSelect_RetDone;
}

}  // namespace

int main(int argc, char** argv) {
  if (argc != 2) return 2;
  const std::string folder = std::string(argv[1]) + "/";
  const TopoDS_Shape cylinder = BRepPrimAPI_MakeCylinder(1, 1).Shape();
  bool ok = write_step(cylinder, folder + "cylinder.step");
  ok = ok && write_step(cylinder, folder + "cylinder_inch.stp", "INCH");
  ok = ok && write_step(BRepPrimAPI_MakeSphere(1).Shape(), folder + "ball.step");
  ok = ok && write_step(spline_prism(), folder + "spline.step");
  ok = ok && write_step(boxes(), folder + "boxes.step");
  ok = ok && write_step(BRepPrimAPI_MakeBox(1, 1, 0.02).Shape(), folder + "plate.step");
  ok = ok && BRepTools::Write(cylinder, (folder + "cylinder.brep").c_str());
  IGESControl_Writer iges;
  iges.AddShape(cylinder);
  iges.ComputeModel();
  return ok && iges.Write((folder + "cylinder.igs").c_str()) ? 0 : 1;
}
