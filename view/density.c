/* SPDX-License-Identifier: Apache-2.0 */
#include "density.h"

#include <stdbool.h>
#include <stdlib.h>

static bool is_likely(double dpi)
{
    return dpi >= 48 && dpi <= 768;
}

#if defined(HAVE_X11) && defined(SDL_VIDEO_DRIVER_X11)
#include <SDL_syswm.h>
#include <X11/Xlib.h>

/* SDL asks XRandR alone, which some servers have no answer for. */
static double find_x11_dpi(SDL_Window *window)
{
    SDL_SysWMinfo info;
    SDL_VERSION(&info.version);
    if (!SDL_GetWindowWMInfo(window, &info) || info.subsystem != SDL_SYSWM_X11)
        return 0;
    Display *display = info.info.x11.display;
    const char *text = XGetDefault(display, "Xft", "dpi");
    const double chosen = text ? strtod(text, NULL) : 0;
    if (is_likely(chosen))
        return chosen;
    const int screen = XDefaultScreen(display);
    const double height_mm = XDisplayHeightMM(display, screen);
    return height_mm > 0 ? 25.4 * XDisplayHeight(display, screen) / height_mm : 0;
}
#else
static double find_x11_dpi(SDL_Window *window)
{
    (void)window;
    return 0;
}
#endif

double density_find_dpi(SDL_Window *window)
{
    float dpi;
    const double found = find_x11_dpi(window);
    if (is_likely(found))
        return found;
    const int display = SDL_GetWindowDisplayIndex(window);
    if (SDL_GetDisplayDPI(display < 0 ? 0 : display, NULL, &dpi, NULL) == 0 &&
        is_likely(dpi))
        return dpi;
    return 96;
}
