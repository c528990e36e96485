/* SPDX-License-Identifier: Apache-2.0 */
/*
 * What Python.h asks of Windows x64 and MinGW, for extensions of the limited API: with it
 * the headers of Debian's Python serve. Not a file of Python's.
 */
#ifndef Py_CONFIG_H
#define Py_CONFIG_H

#define MS_WIN32 1
#define MS_WINDOWS 1
#define MS_WIN64 1
#define PLATFORM "win32"
#define HAVE_DECLSPEC_DLL 1
#define Py_ENABLE_SHARED 1
#define ALIGNOF_SIZE_T 8
#define SIZEOF_VOID_P 8
#define SIZEOF_SIZE_T 8
#define SIZEOF_TIME_T 8
#define SIZEOF_WCHAR_T 2
#define SIZEOF_SHORT 2
#define SIZEOF_INT 4
#define SIZEOF_LONG 4
#define SIZEOF_LONG_LONG 8
#define SIZEOF_DOUBLE 8
#define SIZEOF_FLOAT 4
#define HAVE_WCHAR_H 1
#define HAVE_STDDEF_H 1
#define HAVE_STDINT_H 1
#define HAVE_SYS_TYPES_H 1
#define HAVE_SYS_STAT_H 1
#define HAVE_ERRNO_H 1
#define HAVE_LONG_LONG 1
#define HAVE_PROTOTYPES 1
#define STDC_HEADERS 1
#define WITH_THREAD 1
#define NT_THREADS 1
#define WITH_DOC_STRINGS 1

#endif
