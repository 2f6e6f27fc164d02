// An angle bracket of 5 mm sheet with a rounded inner corner and a bolt hole in its upright leg, in millimetres.
// gmsh bracket.geo -3 -order 2 -format msh41 -o bracket.msh
SetFactory("OpenCASCADE");
thick = 5; foot = 60; upright = 50; width = 30; fillet = 5;
Point(1) = {0, 0, 0};                Point(2) = {foot, 0, 0};
Point(3) = {foot, 0, thick};         Point(4) = {thick + fillet, 0, thick};
Point(5) = {thick, 0, thick + fillet}; Point(6) = {thick, 0, upright};
Point(7) = {0, 0, upright};          Point(8) = {thick + fillet, 0, thick + fillet};
Line(1) = {1, 2}; Line(2) = {2, 3}; Line(3) = {3, 4}; Circle(4) = {4, 8, 5};
Line(5) = {5, 6}; Line(6) = {6, 7}; Line(7) = {7, 1};
Curve Loop(1) = {1:7};
Plane Surface(1) = {1};
Extrude {0, width, 0} { Surface{1}; }
Cylinder(2) = {-1, width/2, 35, thick + 2, 0, 0, 5};
BooleanDifference{ Volume{1}; Delete; }{ Volume{2}; Delete; }
e = 0.01;
bottom() = Surface In BoundingBox {-e, -e, -e, foot + e, width + e, e};
round() = Surface In BoundingBox {thick - e, -e, thick - e, thick + fillet + e, width + e, thick + fillet + e};
bore() = Surface In BoundingBox {-e, width/2 - 5 - e, 30 - e, thick + e, width/2 + 5 + e, 40 + e};
Physical Volume("bracket") = Volume{:};
Physical Surface("foot") = bottom();
Physical Surface("fillet") = round();
Physical Surface("bore") = bore();
Mesh.MeshSizeMax = 7.5; Mesh.MeshSizeMin = 2.5;
Mesh.MeshSizeFromCurvature = 12;
