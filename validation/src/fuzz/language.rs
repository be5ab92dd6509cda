//! All of the language of scenes, to start from.

/// Small scenes that between them say all that a scene can say.
pub(super) const SMALL: &[&str] = &[
    r#"PlaneStrain(
    title: "a heavy block", mesh: Box(axes: [Uniform(from: 0, to: 2, cells: 2), Graded(from: 0, to: 2, cells: 2, ratio: 1.5)]),
    basis: Cpdi2q, domains: (corner_weights: Frozen, fallback_beyond: 0.5, control: Split(cells: 0.9, growth: 4)),
    stabilisation: Ghost(factor: 0.03),
    materials: { "clay": VonMises(young: 1e3, poisson: 0.3, yield_radius: 4, density: 2) },
    bodies: [(name: "block", material: "clay", shape: Box(from: (0, 0), to: (1, 1)), points_per_cell: 2, mean_dilatation: Points)],
    supports: [(name: "base", region: Plane(axis: Y, at: 0), fix: [X, Y])],
    loads: [BodyForce(acceleration: (0, -1)), PointForce(body: "block", near: (1, 1), points: 2, force: (0.1, 0), ramp: [(0, 0), (0.5, 1)])],
    schedule: (steps: 3, cuts: 4), tolerance: (residual: 1e-8, iterations: 12),
    output: (fields: [CauchyStress, Displacement, Plastic, DomainMeasure], every: 2, domain_history: true, checkpoint: (every: 2, seconds: 60)),
)"#,
    r#"Solid(
    mesh: Box(axes: [Uniform(from: 0, to: 1, cells: 1), Nodes([0, 0.5, 2]), Uniform(from: 0, to: 2, cells: 2)]),
    motion: Stretch([(axis: Z, anchor: 0, driven: 1, displacement: 0.1, ramp: [(0, 0), (1, 1)])]),
    basis: Gimp, domains: (gimp_update: Volume),
    materials: { "a": Hencky(young: 10, poisson: 0.2) },
    bodies: [(name: "b", material: "a", shape: Box(from: (0, 0, 0), to: (1, 0.5, 1)), points_per_cell: 2)],
    supports: [
        (name: "base", region: All([Plane(axis: Z, at: 0), Everywhere]), fix: [X, Y, Z]),
        (name: "top", region: Plane(axis: Z, at: 1), follow_mesh: [Z], fix: [X, Y]),
    ],
    loads: [Traction(body: "b", axis: Y, at: 0.5, within: (from: (0, 0, 0), to: (1, 1, 1)), resultant: (0, 0.1, 0))],
    schedule: (steps: 2),
)"#,
    r#"PlaneStrain(
    mesh: Ring(centre: (0, 0), radii: Uniform(from: 1, to: 2, cells: 2), sectors: 6),
    motion: Twist(inner: 2, outer: 0, ramp: [(0, 0), (1, 1)], reindexing: WholeCells),
    basis: Cpdi1, domains: (control: Reshape(cells: 0.7)),
    materials: { "m": VonMises(young: 1e3, poisson: 0, yield_radius: 5) },
    bodies: [(name: "ring", material: "m", shape: Ring(inner: 1, outer: 2), points_per_cell: 1, mean_dilatation: Cell)],
    supports: [
        (name: "inner", region: Circle(radius: 1), follow_mesh: [X, Y], moment_about: (0, 0)),
        (name: "outer", region: Annulus(inner: 1.9, outer: 2.1), fix: [X, Y]),
        (name: "end", region: All([Ray(angle: 0), Circle(radius: 1.5)]), fix: [Y]),
    ],
    schedule: (steps: 60, control: Path(first: 0.5, longest: 1, iterations: 5, measure: ArcLength(most: 1))),
)"#,
    r#"PlaneStrain(
    mesh: Box(axes: [Uniform(from: 0, to: 2, cells: 2), Uniform(from: 0, to: 2, cells: 2)]),
    motion: Corners([(corner: (2, 2), displacement: (0.2, 0.2))]),
    basis: Cpdi2t, domains: (triangles: Cross),
    materials: { "m": Hencky(young: 1e3, poisson: 0.4), "n": VonMises(young: 1, poisson: 0, yield_radius: 1) },
    bodies: [
        (name: "a", material: "m", shape: Box(from: (0, 0), to: (1, 2)), points_per_cell: 2),
        (name: "b", material: "n", shape: Box(from: (1, 0), to: (2, 1)), points_per_cell: 2),
    ],
    supports: [
        (name: "left", region: Plane(axis: X, at: 0), fix: [X]), (name: "base", region: Box(from: (0, 0), to: (2, 0)), fix: [Y]),
        (name: "corner", region: Point(1, 2), displace: [(axis: Y, by: 0.1, ramp: [(0, 0), (1, 1)])]),
    ],
    schedule: (steps: 60, control: Path(first: 0.1, measure: Dissipation(most: 1))),
)"#,
    r#"Solid(
    mesh: Ring(radii: Nodes([1, 1.5, 2]), sectors: 4, angles: (0, 90), height: Uniform(from: 0, to: 1, cells: 1)),
    motion: Rotate(centre: (0, 0), angle: 5), basis: Smpm,
    materials: { "a": Hencky(young: 10, poisson: 0.2, density: 1) },
    bodies: [(name: "b", material: "a", shape: Ring(inner: 1, outer: 1.5), points_per_cell: 2)],
    supports: [(name: "in", region: Circle(radius: 1), follow_mesh: [X, Y], fix: [Z], moment_about: (0, 0))],
    loads: [BodyForce(acceleration: (0, 0, -1))],
    schedule: (steps: 2),
)"#,
    r#"PlaneStrain(
    mesh: Box(axes: [Uniform(from: -2, to: 2, cells: 8), Uniform(from: -2, to: 2, cells: 8)]),
    motion: Rotate(angle: 30, ramp: [(0, 1), (1, 1)]), basis: Smpm,
    materials: { "a": Hencky(young: 1e3, poisson: 0.3) },
    bodies: [(name: "disc", material: "a", shape: Ring(inner: 0.75, outer: 1.25), points_per_cell: 2)],
    stabilisation: Ghost(),
    supports: [(name: "right", region: Point(1, 0), fix: [X, Y]), (name: "left", region: Point(-1, 0), fix: [X, Y])],
    loads: [Vortex(body: "disc", angle: 0.1)],
    schedule: (steps: 2), output: (fields: []),
)"#,
    r#"Solid(
    mesh: Box(axes: [Uniform(from: 0, to: 4, cells: 4), Uniform(from: 0, to: 4, cells: 4), Uniform(from: 0, to: 2, cells: 2)]),
    motion: Fixed, basis: Cpdi2Hexahedron, domains: (control: Cap(cells: 0.9)), solver: Iterative, stabilisation: Ghost(),
    materials: { "a": Hencky(young: 10, poisson: 0.2, density: 1) },
    bodies: [
        (name: "pile", material: "a", shape: Cylinder(axis: Z, centre: (2, 2), radius: 0.8, extent: (0, 1)), points_per_cell: 1),
        (name: "soil", material: "a", shape: Box(from: (1, 1, 0), to: (3, 3, 1), without: ["pile"]), points_per_cell: 1),
    ],
    supports: [
        (name: "base", region: Plane(axis: Z, at: 0), fix: [Z]),
        (name: "turned", region: All([Plane(axis: Z, at: 0), Box(from: (2, 1, 0), to: (3, 3, 0))]), turn: (axis: Z, centre: (2, 2), angle: 5)),
    ],
    loads: [BodyForce(acceleration: (0, 0, -0.1))],
    probes: [
        (name: "all", body: "pile", points: All), (name: "one", body: "soil", points: Near(1, 1, 1)),
        (name: "some", body: "soil", points: Within(from: (1, 1, 0), to: (3, 3, 1))),
    ],
    schedule: (steps: 2, predictor: Rest, control: Load), tolerance: (residual: 1e-8, keep_factor_below: 0.1),
    output: (fields: [Displacement, VolumeRatio, DeformationGradient], energies: true, condition: true),
)"#,
    r#"PlaneStrain(
    mesh: Box(axes: [Uniform(from: 0, to: 3, cells: 3), Uniform(from: 0, to: 3, cells: 3)]),
    basis: Gimp, domains: (gimp_update: Diagonal), solver: Direct, stabilisation: Ghost(),
    materials: { "a": VonMises(young: 1e3, poisson: 0.3, yield_radius: 4, density: 1) },
    bodies: [(name: "tube", material: "a", shape: Tube(centre: (1.5, 1.5), inner: 0.5, outer: 1.3), points_per_cell: 3)],
    supports: [(name: "base", region: Plane(axis: Y, at: 0), fix: [X, Y])],
    loads: [BodyForce(acceleration: (0, -1))],
    schedule: (steps: 2, predictor: LastStep), output: (fields: [ElasticStrain], energies: true),
)"#,
    r#"Solid(
    mesh: Box(axes: [Uniform(from: 0, to: 2, cells: 2), Uniform(from: 0, to: 2, cells: 2), Uniform(from: 0, to: 2, cells: 2)]),
    basis: Cpdi2Tetrahedron, domains: (fallback_beyond: 2, control: Split(cells: 0.9, growth: 4)),
    materials: { "a": VonMises(young: 1e3, poisson: 0.3, yield_radius: 4, density: 1) },
    bodies: [(name: "b", material: "a", shape: Box(from: (0, 0, 0), to: (1, 1, 1)), points_per_cell: 1)],
    supports: [(name: "base", region: Plane(axis: Z, at: 0), fix: [X, Y, Z])],
    loads: [BodyForce(acceleration: (0, 0.2, -1))],
    schedule: (steps: 2), output: (fields: [CornersOutside, FallenBack], domain_history: true),
)"#,
];

/// Words of the language that none of the scenes says.
pub(super) const WORDS: &[&str] = &[
    "Auto",
    "Backslash",
    "Body",
    "Current",
    "None",
    "Outline",
    "SingleCornerNodes",
    "Slash",
    "SmallestCornerWeight",
    "scale",
    "shift",
];
