/* SPDX-License-Identifier: MIT */
/* Made by servogen 0.1.0 from tables.h.jinja; not to be edited. Design 57e8c839fdacd111. */
/* Constant tables of centre; included by centre.c only. */
#ifndef CENTRE_TABLES_H
#define CENTRE_TABLES_H

/* m: points nearer than this make no direction */
static const sg_real centre_apart = 1.9073487e-07f;
/* no direction's square is below, nor that of two */
static const sg_real centre_least_square = 0.5f;
/* beta / (alpha + beta) */
static const sg_real centre_share = 0.9836066f;
/* alpha / (alpha + beta), below any pivot */
static const sg_real centre_least_price = 0.016393442f;
/* nothing left of the slides' matrix is beyond */
static const sg_real centre_stiffest = 64.0f;
/* m: no slide is, nor what becomes one */
static const sg_real centre_farthest = 1265.2084f;
/* largest hidden state */
static const sg_real centre_hidden_bound = 2.0f;
/* two positions are not farther apart */
static const sg_real centre_twice_reach = 0.1f;
/* largest command */
static const sg_real centre_limit_x = 20.0f;
/* position by the position, less one */
static const sg_real centre_drift_x = 5.2576006e-06f;
/* position by the input */
static const sg_real centre_drive_x = 4.02e-07f;
/* Kalman gain of it, less one */
static const sg_real centre_gain_x = -0.6192807f;
/* largest command */
static const sg_real centre_limit_y = 20.0f;
/* position by the position, less one */
static const sg_real centre_drift_y = -7.962737e-06f;
/* position by the input */
static const sg_real centre_drive_y = 3.32e-07f;
/* Kalman gain of it, less one */
static const sg_real centre_gain_y = -0.6310153f;

/* (d_1..d_N, y, xi) to the first input; 13 */
SG_PRAGMA("DATA_ALIGN(centre_first_x, 8)")
static const sg_real centre_first_x[13] = {
    1281.1296f, 18868.877f, 23957.895f, 12360.594f, 1121.1451f, -2118.3503f, -629.6724f,
    817.08514f, 1043.6545f, -249.81827f, 2.1983914f, -42.65278f, -16.512291f
};

/* the same to errors left, transposed; 13 x 9 */
SG_PRAGMA("DATA_ALIGN(centre_error_x, 8)")
static const sg_real centre_error_x[117] = {
    -0.9831f, 0.0074609397f, 0.009473187f, 0.0048875003f, 0.00044331182f, -0.0008376165f,
    -0.00024897867f, 0.0003230835f, 0.0003174209f, 0.0074609397f, -0.87321293f, 0.146985f,
    0.081457816f, 0.011416735f, -0.0118933655f, -0.004504652f, 0.004509496f, 0.0049981577f,
    0.009473187f, 0.146985f, -0.69605863f, 0.2383842f, 0.08974802f, -0.004247198f,
    -0.016549418f, 0.0015372037f, 0.010445458f, 0.0048875003f, 0.081457816f, 0.2383842f,
    -0.6489031f, 0.24266136f, 0.08166652f, -0.006649394f, -0.013432243f, 0.004599744f,
    0.00044331182f, 0.011416735f, 0.08974802f, 0.24266136f, -0.6485151f, 0.24192834f,
    0.08144864f, -0.006366656f, -0.013154461f, -0.0008376165f, -0.0118933655f, -0.004247198f,
    0.08166652f, 0.24192834f, -0.64713013f, 0.24234003f, 0.080914415f, -0.0068915123f,
    -0.00024897867f, -0.004504652f, -0.016549418f, -0.006649394f, 0.08144864f, 0.24234003f,
    -0.6470077f, 0.24218124f, 0.08075841f, 0.0003230835f, 0.004509496f, 0.0015372037f,
    -0.013432243f, -0.006366656f, 0.080914415f, 0.24218124f, -0.64680165f, 0.24238369f,
    0.00041267127f, 0.006447919f, 0.012608156f, 0.0010645738f, -0.030521628f, -0.033773772f,
    0.066667445f, 0.2448359f, -0.7171934f, -9.8780605e-05f, -0.0011878633f, 0.0030313712f,
    0.019140689f, 0.037569277f, 0.033935346f, 0.014253529f, 0.078465894f, 0.39388993f,
    6.040676e-06f, 9.64566e-06f, 5.800864e-06f, 1.0140973e-06f, -8.603528e-07f, -8.367757e-07f,
    -9.15827e-07f, -1.4488838e-06f, -1.9706688e-06f, 0.0003347442f, 0.00043424027f,
    0.0002243814f, 1.9435622e-05f, -3.945263e-05f, -1.18604e-05f, 1.4846224e-05f,
    1.4669548e-05f, 3.5220746e-06f, -6.529122e-06f, 9.4721254e-05f, 9.5431715e-05f,
    3.585267e-05f, -5.196012e-06f, -9.961965e-06f, -5.818474e-07f, 4.3869477e-06f, 2.911289e-06f
};

/* first input per slide; 9 */
SG_PRAGMA("DATA_ALIGN(centre_slide_x, 8)")
static const sg_real centre_slide_x[9] = {
    1281.1296f, 18868.877f, 23957.895f, 12360.594f, 1121.1451f, -2118.3503f, -629.6724f,
    817.08514f, 802.76434f
};

/* errors left per slide; 9 x 9 */
SG_PRAGMA("DATA_ALIGN(centre_stiffness_x, 8)")
static const sg_real centre_stiffness_x[81] = {
    0.9831f, -0.0074609397f, -0.009473187f, -0.0048875003f, -0.00044331182f, 0.0008376165f,
    0.00024897867f, -0.0003230835f, -0.0003174209f, -0.0074609397f, 0.87321293f, -0.146985f,
    -0.081457816f, -0.011416735f, 0.0118933655f, 0.004504652f, -0.004509496f, -0.0049981577f,
    -0.009473187f, -0.146985f, 0.69605863f, -0.2383842f, -0.08974802f, 0.004247198f,
    0.016549418f, -0.0015372037f, -0.010445458f, -0.0048875003f, -0.081457816f, -0.2383842f,
    0.6489031f, -0.24266136f, -0.08166652f, 0.006649394f, 0.013432243f, -0.004599744f,
    -0.00044331182f, -0.011416735f, -0.08974802f, -0.24266136f, 0.6485151f, -0.24192834f,
    -0.08144864f, 0.006366656f, 0.013154461f, 0.0008376165f, 0.0118933655f, 0.004247198f,
    -0.08166652f, -0.24192834f, 0.64713013f, -0.24234003f, -0.080914415f, 0.0068915123f,
    0.00024897867f, 0.004504652f, 0.016549418f, 0.006649394f, -0.08144864f, -0.24234003f,
    0.6470077f, -0.24218124f, -0.08075841f, -0.0003230835f, -0.004509496f, -0.0015372037f,
    0.013432243f, 0.006366656f, -0.080914415f, -0.24218124f, 0.64680165f, -0.24238369f,
    -0.0003174209f, -0.0049981577f, -0.010445458f, -0.004599744f, 0.013154461f, 0.0068915123f,
    -0.08075841f, -0.24238369f, 0.64660275f
};

/* A, hidden to hidden, transposed; 2 x 2 */
SG_PRAGMA("DATA_ALIGN(centre_on_hidden_x, 8)")
static const sg_real centre_on_hidden_x[4] = {
    0.98889476f, -1.222062f, 0.5645514f, -0.2916f
};

/* position by the hidden states; 2 */
SG_PRAGMA("DATA_ALIGN(centre_hidden_moves_x, 8)")
static const sg_real centre_hidden_moves_x[2] = {
    0.0003574697f, 0.0f
};

/* hidden states by the position; 2 */
SG_PRAGMA("DATA_ALIGN(centre_hidden_drift_x, 8)")
static const sg_real centre_hidden_drift_x[2] = {
    -0.043519855f, -0.04812006f
};

/* hidden states by the input; 2 */
SG_PRAGMA("DATA_ALIGN(centre_hidden_drive_x, 8)")
static const sg_real centre_hidden_drive_x[2] = {
    0.016259482f, 0.0008403885f
};

/* Kalman gain of them; 2 */
SG_PRAGMA("DATA_ALIGN(centre_hidden_gain_x, 8)")
static const sg_real centre_hidden_gain_x[2] = {
    135.21863f, -294.02002f
};

/* (d_1..d_N, y, xi) to the first input; 15 */
SG_PRAGMA("DATA_ALIGN(centre_first_y, 8)")
static const sg_real centre_first_y[15] = {
    1081.057f, 20615.818f, 24194.605f, 7591.1924f, -2001.1003f, 1942.2528f, 5952.757f,
    2661.6384f, -4695.618f, -279.4298f, -2.0861588f, -6.0713744f, -30.377378f, -41.523388f,
    -2.1485987f
};

/* the same to errors left, transposed; 15 x 9 */
SG_PRAGMA("DATA_ALIGN(centre_error_y, 8)")
static const sg_real centre_error_y[135] = {
    -0.98325354f, 0.006732248f, 0.007900926f, 0.0024789597f, -0.00065347407f, 0.000634257f,
    0.0019439165f, 0.00086917763f, -0.0008173048f, 0.006732248f, -0.8548692f, 0.15740338f,
    0.05517483f, -0.009982829f, 0.011441843f, 0.03770486f, 0.018519184f, -0.014716873f,
    0.007900926f, 0.15740338f, -0.6780424f, 0.21288376f, 0.04054975f, 0.004212165f,
    0.054947685f, 0.057157498f, 0.00022748625f, 0.0024789597f, 0.05517483f, 0.21288376f,
    -0.6606351f, 0.20829506f, 0.045003507f, 0.017862365f, 0.06105106f, 0.051418375f,
    -0.00065347407f, -0.009982829f, 0.04054975f, 0.20829506f, -0.6594255f, 0.20712101f,
    0.041405205f, 0.016253466f, 0.06256394f, 0.000634257f, 0.011441843f, 0.004212165f,
    0.045003507f, 0.20712101f, -0.658286f, 0.21061349f, 0.04296679f, 0.0147850765f,
    0.0019439165f, 0.03770486f, 0.054947685f, 0.017862365f, 0.041405205f, 0.21061349f,
    -0.647582f, 0.21539955f, 0.038466364f, 0.00086917763f, 0.018519184f, 0.057157498f,
    0.06105106f, 0.016253466f, 0.04296679f, 0.21539955f, -0.645442f, 0.2133873f, -0.0015333887f,
    -0.027808294f, -0.003201487f, 0.09531617f, 0.13278584f, 0.036125146f, -0.015519392f,
    0.13960049f, -0.7527923f, -9.1249865e-05f, -0.0039291f, -0.046376605f, -0.09914489f,
    -0.07255745f, 0.037435796f, 0.12310065f, 0.17938246f, 0.43009734f, -8.513451e-06f,
    -1.4224302e-05f, -5.285893e-06f, 2.792876e-06f, 9.1309334e-07f, -4.14186e-06f,
    -3.8905487e-06f, 1.1154095e-06f, 5.033302e-06f, -1.982652e-06f, -4.2224303e-05f,
    5.9430913e-06f, 8.3647734e-05f, 8.973121e-05f, 2.8879882e-05f, -2.7221697e-05f,
    -4.0812378e-05f, -2.7360646e-05f, -9.919957e-06f, 0.000204268f, 0.00017389945f,
    1.8503086e-05f, -2.7929154e-05f, 2.4238676e-05f, 4.6298504e-05f, 7.911229e-06f,
    -2.8144099e-05f, 0.00051530905f, 0.0005259517f, 0.000110416266f, -7.369713e-05f,
    5.251599e-05f, 0.00014373142f, 5.5897704e-05f, -6.133672e-05f, -7.5281576e-05f,
    -7.016407e-07f, -1.482214e-05f, -4.6347526e-05f, -2.535851e-05f, 3.404915e-05f,
    6.516524e-05f, 4.5209672e-05f, 6.4959017e-06f, -1.735718e-05f
};

/* first input per slide; 9 */
SG_PRAGMA("DATA_ALIGN(centre_slide_y, 8)")
static const sg_real centre_slide_y[9] = {
    1081.057f, 20615.818f, 24194.605f, 7591.1924f, -2001.1003f, 1942.2528f, 5952.757f,
    2661.6384f, -2502.791f
};

/* errors left per slide; 9 x 9 */
SG_PRAGMA("DATA_ALIGN(centre_stiffness_y, 8)")
static const sg_real centre_stiffness_y[81] = {
    0.98325354f, -0.006732248f, -0.007900926f, -0.0024789597f, 0.00065347407f, -0.000634257f,
    -0.0019439165f, -0.00086917763f, 0.0008173048f, -0.006732248f, 0.8548692f, -0.15740338f,
    -0.05517483f, 0.009982829f, -0.011441843f, -0.03770486f, -0.018519184f, 0.014716873f,
    -0.007900926f, -0.15740338f, 0.6780424f, -0.21288376f, -0.04054975f, -0.004212165f,
    -0.054947685f, -0.057157498f, -0.00022748625f, -0.0024789597f, -0.05517483f, -0.21288376f,
    0.6606351f, -0.20829506f, -0.045003507f, -0.017862365f, -0.06105106f, -0.051418375f,
    0.00065347407f, 0.009982829f, -0.04054975f, -0.20829506f, 0.6594255f, -0.20712101f,
    -0.041405205f, -0.016253466f, -0.06256394f, -0.000634257f, -0.011441843f, -0.004212165f,
    -0.045003507f, -0.20712101f, 0.658286f, -0.21061349f, -0.04296679f, -0.0147850765f,
    -0.0019439165f, -0.03770486f, -0.054947685f, -0.017862365f, -0.041405205f, -0.21061349f,
    0.647582f, -0.21539955f, -0.038466364f, -0.00086917763f, -0.018519184f, -0.057157498f,
    -0.06105106f, -0.016253466f, -0.04296679f, -0.21539955f, 0.645442f, -0.2133873f,
    0.0008173048f, 0.014716873f, -0.00022748625f, -0.051418375f, -0.06256394f, -0.0147850765f,
    -0.038466364f, -0.2133873f, 0.6435498f
};

/* A, hidden to hidden, transposed; 4 x 4 */
SG_PRAGMA("DATA_ALIGN(centre_on_hidden_y, 8)")
static const sg_real centre_on_hidden_y[16] = {
    0.7378f, 0.34757134f, 0.0f, -0.70645976f, 0.075595185f, -0.0227f, 0.7631437f, -0.15957457f,
    0.6426085f, -0.71929336f, 0.504708f, 0.35555252f, 0.5464109f, 0.0f, 0.0f, 0.5109f
};

/* position by the hidden states; 4 */
SG_PRAGMA("DATA_ALIGN(centre_hidden_moves_y, 8)")
static const sg_real centre_hidden_moves_y[4] = {
    0.0f, 0.0f, 0.0005376833f, 0.0f
};

/* hidden states by the position; 4 */
SG_PRAGMA("DATA_ALIGN(centre_hidden_drift_y, 8)")
static const sg_real centre_hidden_drift_y[4] = {
    -0.006460387f, 0.0608207f, 0.030135304f, -0.009173947f
};

/* hidden states by the input; 4 */
SG_PRAGMA("DATA_ALIGN(centre_hidden_drive_y, 8)")
static const sg_real centre_hidden_drive_y[4] = {
    0.0013309107f, 0.00522238f, 0.01156782f, -0.00077252963f
};

/* Kalman gain of them; 4 */
SG_PRAGMA("DATA_ALIGN(centre_hidden_gain_y, 8)")
static const sg_real centre_hidden_gain_y[4] = {
    224.43979f, -99.66265f, 52.241047f, -45.306236f
};

#endif
