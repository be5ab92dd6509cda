% The self-weight column of `scenes/column.ron` with AMPLE, to be timed as a whole process of GNU Octave.
%
%     octave-cli --no-init-file benchmarks/foreign/ample_column.m AMPLE_FOLDER [CELLS] [STEPS] [YOUNG] [gimp|standard]
%
% AMPLE_FOLDER is the unpacked AMPLE (https://wmcoombs.github.io; run with commit 1f7bebb), with the folders `functions`, `constitutive`, `setup`. This script gives
% AMPLE's functions the column and walks through the load steps with them; it writes no pictures, which AMPLE's own main script does at every step.
% 2² points a cell, Hencky's law, the weight in as many equal steps, Newton's method to 1e-9 of the forces. Prints the mean error of the vertical stress.

1;

function points = points_of(cells, side, kind, young, density)
  % Two by two points in every cell of the column.
  p = 0;
  for row = 0:cells - 1
    for place = [0.25 0.25 0.75 0.75; 0.25 0.75 0.25 0.75]
      p = p + 1;
      point.mpType = kind;
      point.cmType = 1;
      point.mpC = [place(1) * side(1), (row + place(2)) * side(2)];
      point.vp = prod(side) / 4;
      point.vp0 = point.vp;
      point.mpM = point.vp * density;
      [point.nIN, point.eIN, point.nSMe] = deal(zeros(4, 1), 0, 0);
      [point.Svp, point.dSvp] = deal(zeros(1, 4), zeros(2, 4));
      [point.Fn, point.F] = deal(eye(3));
      [point.sig, point.epsEn, point.epsE] = deal(zeros(6, 1));
      point.mCst = [young, 0];
      [point.fp, point.u] = deal(zeros(2, 1));
      % Half sides of the domain; a point of the standard method has none.
      [point.lp, point.lp0] = deal((kind == 2) * side / 4);
      points(p) = point;
    end
  end
end

function [moved, points, iteration] = load_step(mesh, points, force)
  % Newton's method with AMPLE's functions: displacement of the nodes under `force`, and how many linear solutions it took.
  [reaction, moved, tangent, out] = deal(zeros(size(force)), zeros(size(force)), 0, force);
  free = detFDoFs(mesh);
  for iteration = 0:20
    % The first call only makes room: there is no tangent yet.
    [increment, held] = linSolve(mesh.bc, tangent, out, iteration, free);
    [moved, reaction] = deal(moved + increment, reaction + held);
    [internal, tangent, points] = detMPs(moved, points);
    out = force - internal + reaction;
    if iteration > 0 && norm(out) <= 1e-9 * norm(force + reaction)
      return
    end
  end
  error('Newton''s method has not converged in %d iterations: residual %g', iteration, norm(out) / norm(force + reaction));
end

words = argv();
if numel(words) < 1 || ! isfolder(fullfile(words{1}, 'functions'))
  fprintf(stderr, 'ample_column.m: expected the folder of AMPLE, with a folder `functions` in it, as the first argument\n');
  exit(2);
end
for folder = {'functions', 'constitutive', 'setup'}
  addpath(fullfile(words{1}, folder{1}));
end
words(end + 1:5) = {''};
[cells, steps, young, kind] = deal(64, 40, 1e4, 2);
if ! isempty(words{2}), cells = str2double(words{2}); end
if ! isempty(words{3}), steps = str2double(words{3}); end
if ! isempty(words{4}), young = str2double(words{4}); end
if strcmp(words{5}, 'standard'), kind = 1; end

[height, width, density, gravity] = deal(50, 3.125, 80, 10);
[mesh.etpl, mesh.coord] = formCoord2D(1, cells, width, height);
mesh.h = [width, height / cells];
nodes = size(mesh.coord, 1);
% Sides held across, the base along the column.
held = [2 * (1:nodes) - 1, 2 * find(mesh.coord(:, 2)' == 0)]';
mesh.bc = [held, zeros(numel(held), 1)];
points = points_of(cells, mesh.h, kind, young, density);
solutions = 0;
at_rest = cat(1, points.mpC);
for step = 1:steps
  [mesh, points] = elemMPinfo(mesh, points);
  weight = detExtForce(nodes, 2, gravity, points) * step / steps;
  [moved, points, iterations] = load_step(mesh, points, weight);
  solutions = solutions + iterations;
  points = updateMPs(moved, points);
end
stress = [points.sig](2, :)';
places = cat(1, points.mpC);
exact = -density * gravity * (height - at_rest(:, 2));
printf('%d points, highest at %.10f, %d linear solutions\n', numel(points), max(places(:, 2)), solutions);
printf('mean stress error %.6e\n', mean(abs(stress - exact)) / (density * gravity * height));
