/* SPDX-License-Identifier: Apache-2.0 */
/* OpenEXRCore's HTJ2K compression is C++; image_open() refuses files that need it. */
#include "internal_compress.h"
#include "internal_decompress.h"

exr_result_t internal_exr_apply_ht(exr_encode_pipeline_t *encode)
{
    (void)encode;
    return EXR_ERR_FEATURE_NOT_IMPLEMENTED;
}

exr_result_t internal_exr_undo_ht(exr_decode_pipeline_t *decode, const void *packed,
                                  uint64_t n_packed, void *out, uint64_t n_out)
{
    (void)decode;
    (void)packed;
    (void)n_packed;
    (void)out;
    (void)n_out;
    return EXR_ERR_FEATURE_NOT_IMPLEMENTED;
}
