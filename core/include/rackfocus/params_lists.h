/* SPDX-License-Identifier: Apache-2.0 */
/*
 * The choices of every enumerated parameter: X(CONSTANT, "name", "what it is").
 * A constant's value is its place in the list. Lists only grow at the end.
 */
#ifndef RACKFOCUS_PARAMS_LISTS_H
#define RACKFOCUS_PARAMS_LISTS_H

#define RF_LIST_SENSOR_FIT(X)                                                          \
    X(RF_SENSOR_FIT_AUTO, "auto", "sensor width along the longer side")                \
    X(RF_SENSOR_FIT_HORIZONTAL, "horizontal", "sensor width along the width")          \
    X(RF_SENSOR_FIT_VERTICAL, "vertical", "sensor height along the height")

#define RF_LIST_PROJECTION(X)                                                          \
    X(RF_PROJECTION_PERSPECTIVE, "perspective", "pinhole")                             \
    X(RF_PROJECTION_ORTHOGRAPHIC, "orthographic", "parallel rays")

#define RF_LIST_OPTICS(X)                                                              \
    X(RF_OPTICS_CAMERA, "camera", "CG camera, as Cycles and POV-Ray: no breathing")    \
    X(RF_OPTICS_LENS, "lens", "real lens: the image lies at f s / (s - f)")            \
    X(RF_OPTICS_YU, "yu", "Yu 2004: screen position and aperture coefficient")         \
    X(RF_OPTICS_BUFFER, "buffer", "Reed: scale and bias on the depth buffer's value")

#define RF_LIST_APERTURE(X)                                                            \
    X(RF_APERTURE_AUTO, "auto", "polygon where blades are given, else disc")           \
    X(RF_APERTURE_DISC, "disc", "circle")                                              \
    X(RF_APERTURE_POLYGON, "polygon", "regular polygon of 3 to 16 blades")             \
    X(RF_APERTURE_IMAGE, "image", "a picture of it, which the filter is given")

#define RF_LIST_ORIENTATION(X)                                                         \
    X(RF_ORIENTATION_CYCLES, "cycles", "middle of an edge to the right")               \
    X(RF_ORIENTATION_POVRAY, "povray", "as POV-Ray's hexagonal sample patterns")

#define RF_LIST_DEPTH(X)                                                               \
    X(RF_DEPTH_PLANAR, "planar", "distance along the camera's axis")                   \
    X(RF_DEPTH_RADIAL, "radial", "distance along the ray")                             \
    X(RF_DEPTH_BUFFER, "buffer", "OpenGL depth buffer, 0 near to 1 far")               \
    X(RF_DEPTH_BUFFER_REVERSED, "buffer-reversed", "depth buffer, 1 near to 0 far")    \
    X(RF_DEPTH_BUFFER_INFINITE, "buffer-infinite", "depth buffer, far at infinity")    \
    X(RF_DEPTH_BUFFER_REVERSED_INFINITE, "buffer-reversed-infinite",                   \
      "reversed depth buffer, far at infinity")                                        \
    X(RF_DEPTH_INVERSE, "inverse", "1 / planar distance")                              \
    X(RF_DEPTH_DISPARITY, "disparity", "scale * value + offset = 1 / distance")        \
    X(RF_DEPTH_NORMALISED, "normalised", "0 at depth-near to 1 at depth-far, linear")

#define RF_LIST_FILM_DEPTH(X)                                                          \
    X(RF_FILM_DEPTH_KEEP, "keep", "as rendered: infinitely far")                       \
    X(RF_FILM_DEPTH_SOLID, "solid", "where alpha is above 0.5, 2 px from a surface")   \
    X(RF_FILM_DEPTH_ALL, "all", "wherever there is something, 2 px from a surface")    \
    X(RF_FILM_DEPTH_EDGES, "edges",                                                    \
      "between a surface and what is empty: rims, soft ones too")

#define RF_LIST_METHOD(X)                                                              \
    X(RF_METHOD_LAYERED, "layered", "occlusion-aware layers, one view; the default")   \
    X(RF_METHOD_SCATTER, "scatter", "each pixel spread over its circle of confusion")  \
    X(RF_METHOD_BOX, "box", "preview: running sums along rows and columns")            \
    X(RF_METHOD_LOWRES, "lowres", "preview: a small picture, magnified")               \
    X(RF_METHOD_MIPMAP, "mipmap", "preview: coarser levels of detail, magnified")      \
    X(RF_METHOD_OFFSET, "offset", "preview: shifted copies, averaged")                 \
    X(RF_METHOD_MIPMAP_OFFSET, "mipmap-offset",                                        \
      "preview: four shifts of a coarser level of detail")                             \
    X(RF_METHOD_RECURSIVE_OFFSET, "recursive-offset",                                  \
      "preview: four shifts in x, four in +, again and again")                         \
    X(RF_METHOD_VIEWS, "views", "several views from points of the lens, merged")       \
    X(RF_METHOD_ACCUMULATE, "accumulate", "the mean of views; needs no depth")

#define RF_LIST_QUALITY(X)                                                             \
    X(RF_QUALITY_PREVIEW, "preview", "drawn at a fraction of the size, for live use")  \
    X(RF_QUALITY_NORMAL, "normal", "at most 3 sub-apertures; loses 0.1 dB at most")    \
    X(RF_QUALITY_BEST, "best", "everything that the other parameters ask for")

#define RF_LIST_DISTRIBUTION(X)                                                        \
    X(RF_DISTRIBUTION_UNIFORM, "uniform", "equal light over the circle (Yu 2004)")     \
    X(RF_DISTRIBUTION_GAUSSIAN, "gaussian", "soft: sigma half the radius")             \
    X(RF_DISTRIBUTION_RING, "ring", "bright rim, four times the centre")               \
    X(RF_DISTRIBUTION_IMAGE, "image", "a picture of the aperture, given beside it")

#define RF_LIST_BLEND(X)                                                               \
    X(RF_BLEND_COC, "coc", "each pixel blurred by its own circle of confusion")        \
    X(RF_BLEND_REGION, "region", "sharp around the focus, a linear ramp outside")      \
    X(RF_BLEND_SLICES, "slices", "planes on both sides of the focus, back to front")

#define RF_LIST_LEAK(X)                                                                \
    X(RF_LEAK_NONE, "none", "colours leak")                                            \
    X(RF_LEAK_PRODUCT, "product", "mean and product of four blurred alphas")           \
    X(RF_LEAK_HINT, "hint", "the blurred alpha")

#define RF_LIST_STAGE(X)                                                               \
    X(RF_STAGE_RESULT, "result", "the filtered picture")                               \
    X(RF_STAGE_LEVELS, "levels", "the levels of detail of mipmap and mipmap-offset")   \
    X(RF_STAGE_ALPHA, "alpha", "how much of the blurred picture is taken")             \
    X(RF_STAGE_SLICES, "slices", "the same, a colour for each slice of blend slices")

#define RF_LIST_DIRECTION(X)                                                           \
    X(RF_DIRECTION_BOTH, "both", "along rows, then along columns")                     \
    X(RF_DIRECTION_HORIZONTAL, "horizontal", "along rows alone, as something moving")  \
    X(RF_DIRECTION_VERTICAL, "vertical", "along columns alone")

#define RF_LIST_LENS_PATTERN(X)                                                        \
    X(RF_LENS_PATTERN_AUTO, "auto", "polygon where blades are given, else disc")       \
    X(RF_LENS_PATTERN_DISC, "disc", "Vogel's spiral over the disc")                    \
    X(RF_LENS_PATTERN_CIRCLE, "circle", "evenly along the rim")                        \
    X(RF_LENS_PATTERN_POLYGON, "polygon", "Vogel's spiral over the polygon of blades") \
    X(RF_LENS_PATTERN_GRID, "grid", "one point at a random place of each equal cell")

#define RF_LIST_EXPOSURE(X)                                                            \
    X(RF_EXPOSURE_FALL, "fall", "the picture darkens as the lens does")                \
    X(RF_EXPOSURE_KEEP, "keep", "only the shape of the blur changes")

#endif
