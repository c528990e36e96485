/* SPDX-License-Identifier: Apache-2.0 */
/* Which parameters a set of parameters leaves without effect: rf_param_is_read(). */
#ifndef RF_METHODS_PARAM_READS_H
#define RF_METHODS_PARAM_READS_H

#include "rackfocus/rackfocus.h"

/* Why a parameter is not read; NULL: it is. `params` knows all parameters. */
typedef const char *(*rf_read_rule)(const struct rf_params *params);

#endif
