/* SPDX-License-Identifier: MIT */
/*
 * Angles that come round. Included after sg_kernels.h, by controllers of an axis that turns on.
 */
#ifndef SG_ANGLE_H
#define SG_ANGLE_H

/*
 * The shortest way along a difference of two positions, in (-half, half]. The whole turns that are taken
 * off are exact, so nothing is rounded there; the nearest number of turns may be one off where half a
 * turn is left over, which the two comparisons mend. `difference` is of so many turns that an int32_t
 * holds their number.
 */
static inline sg_real sg_shortest(sg_real difference, sg_real turn, sg_real half, sg_real inverse)
{
    const sg_real zero = (sg_real)0;
    const sg_real turns = difference * inverse;
    const sg_real nearest = turns + ((turns < zero) ? (sg_real)-0.5 : (sg_real)0.5);
    const int32_t whole = (int32_t)nearest;
    const sg_real first = difference - ((sg_real)whole * turn);
    const sg_real second = first - ((first > half) ? turn : zero);
    const sg_real third = second + ((second <= -half) ? turn : zero);
    return sg_bound(third, -half, half); /* the remainder of a division by the turn */
}

#endif
