"""Every tolerance of the explicit solutions, each with its reason.

The geometry is done in coordinates of the parameters in which one is a bound of the program (see
``image.py``), with rows of unit length. Lengths below are therefore shares of a bound.
"""

from __future__ import annotations

# A singular value of the parameters' map relative to its largest, with columns of unit size: data
# printed with 16 digits and condensed over 50 steps keep about 1e-13; a direction that matters by
# less than this share cannot be told from that noise, and moves no bound by more.
RANK = 1e-10
# Smallest distance of a unit row from the span of the other active rows (LICQ). Multipliers grow
# with its inverse square: 1e-6 leaves four digits of them.
INDEPENDENCE = 1e-6
# A row of a region whose normal is shorter than this, relative to the terms that it is the
# difference of, is a constant: the terms cancel to about 1e-13 at the conditions admitted above.
CONSTANT_ROW = 1e-9
# Radius of the largest ball inside a set that counts as full-dimensional. The linear programs are
# exact to 1e-11 here; the thinnest region of the servo drive with six moves is 1e-4.
FLAT = 1e-8
# The distance from the origin from which on FLAT grows in proportion: ten terms of a sum leave
# 1e-15 of it, planes that meet at a hundredth 1e-13.
FLAT_UP_TO = 1e5
# Two unit rows, or two offsets, that differ by no more are one hyperplane. A facet computed from
# both its sides agrees to about 1e-11; the thinnest set that counts is two of FLAT thick.
SAME_PLANE = 1e-8
# The same of the hyperplanes that a tree may cut by, with lengths in the height of the farthest one
# (1e6 bounds for a position's limits): planes as close as a ten-thousandth of a bound are two.
SAME_CUT = 1e-10
# How far beyond its bound a row may be reached and still be redundant: a tenth of FLAT, so that
# dropping rows cannot make a flat set look full-dimensional.
REDUNDANT = 1e-9
# Two first-move laws are one when their coefficients differ by no more than this, relative to the
# largest coefficient of the two: exact duplicates agree to 1e-12, and a law replaced by another so
# close moves the first move by no more than 1e-9 of a bound per bound of parameter.
SAME_LAW = 1e-9
# A law smaller than this share of the largest is compared as if it were so large: what cancels to
# a move of zero leaves roundings of the terms, which are no larger than those of the largest law.
LEAST_LAW = 1e-5
# The primal and dual residual at which a small linear program's vertex is accepted; beyond it the
# program is handed to HiGHS.
LP_RESIDUAL = 1e-10
# A constraint of the quadratic program counts as violated beyond this; unit rows, one is a bound.
QP_VIOLATION = 1e-11
# What is left of a unit row after projection off the active ones, squared, below which the dual
# method takes it for a combination of them: an angle of 1e-7, for which a projection, exact to
# 1e-16, leaves nine digits. Where a step across a facet ends in the tip of a wedge, rows at smaller
# angles than INDEPENDENCE may be all that is active. To say that nothing is feasible there would
# leave a hole; a set that is found makes a region, whose laws may have lost digits by the square of
# the angle, and the proofs judge it.
QP_DEPENDENT = 1e-14
# Steps across a facet that the adjacency of active sets does not settle. Behind it may lie the tip
# of a wedge, so they go down to a hundred times what the quadratic program resolves.
STEPS_ACROSS = (1e-5, 1e-6, 1e-7, 1e-8, 1e-9)
# Pieces of a facet narrower than this may be left over between what the regions behind it cover.
# Those are known to a few FLAT; where planes meet at a hundredth, that is this wide.
SLIVER = 1e-6
# Beyond a plane there is nothing feasible if the program over parameters and variables reaches no
# further than FLAT, or than this share of its largest bound: vertices that far from the origin are
# found to 1e-10 per thousand, times the multipliers of a few rows.
END_SHARE = 1e-11
# A found neighbour must contain the point of the facet that was stepped across, within a step.
TOUCHES = 1e-7
# Sine of an angle, seen from the generators of a cone, below which a hyperplane only touches it.
# Generators carry about 1e-13; the proof of a tree by linear programs does not rely on this. Angles
# are those of lengths in the height of the farthest plane, 1e6 bounds or less for a position's
# limits: what lies closer to a plane than a millionth of a bound goes to one side of it alone.
TOUCHES_CONE = 1e-12
# How far outside the feasible set, in shares of a bound, a parameter still counts as inside when it
# is looked up: a plant that stands on its limit is feasible whichever way the last digit of its
# measurement and of the sums was rounded. Some 30 terms of size one round to 1e-14 and 4e-6.
EDGE = {"float64": 1e-9, "float32": 1e-5}

# Of the proofs (``certify.py``, ``rim.py``), which compute everything again from the program.
#
# What is left of a row that is a function of eta, over all parameters, relative to the terms that
# it is made of: the image leaves out directions that matter by less than RANK, and a thousand
# roundings of the terms are a hundredth of this.
SEEN = 1e-9
# How far a region may reach beyond where its active set is optimal: planes within SAME_PLANE are
# one when rows are gathered, on both sides of a facet and in either of two regions.
PROVED = 5e-8
# Laws are gathered within SAME_LAW of their largest coefficient; the same again for the roundings
# of the two computations.
PROVED_LAW = 2e-9
# Largest ball, in shares of a bound, that what is left open between regions could hold in sum.
HOLE = 1e-3
# How far out, in shares of a bound, regions are shown to leave nothing out: a turn of a servo axis
# is 1e4 there, a row's direction is known to 1e-13 or so, and this far out that is a tenth of a
# SLIVER.
FAR = 1e6
# What is left of affine functions that cancel, relative to their terms: a function so small is
# nothing, and what it is compared with decides by the order of the rows, as in the method.
CANCELLED = 1e-11
# A piece of parameters is empty if the radius of its largest ball is below minus this, in a unit
# box of parameters: ten times what a linear program's vertex is known to, so that what is kept is
# no less than what there is.
NOT_EMPTY = 1e-9
# The least violation that enters a row, as a distance of parameters in that box, is so many times
# NOT_EMPTY: at once it, pieces that are not there survive and rows come and go hundreds of times.
# Of 62 random programs they did in 12 at once it and in none at one and a half times; at four times
# one bound was not attained, by one iteration.
VIOLATION_SEEN = 4.0
