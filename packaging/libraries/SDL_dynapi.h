/* SPDX-License-Identifier: Apache-2.0 */
/*
 * SDL is linked into the window: no table of all its functions, which would link what the
 * window never calls, and no other SDL by SDL_DYNAMIC_API in the environment. Not a file
 * of SDL's.
 */
#ifndef SDL_dynapi_h_
#define SDL_dynapi_h_

#define SDL_DYNAMIC_API 0

#endif
