/* SPDX-License-Identifier: Apache-2.0 */
#include "exr_private.h"

exr_result_t exr_undo_dwa(exr_decode_pipeline_t *pipeline)
{
    exr_core_on_error(pipeline->context, EXR_ERR_FEATURE_NOT_IMPLEMENTED,
                      "DWAA and DWAB compression are not supported");
    return EXR_ERR_FEATURE_NOT_IMPLEMENTED;
}
