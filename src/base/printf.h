/* printf: functions whose arguments the compiler checks as printf's. Argument number text is the
 * format; the arguments of the format begin at number first.
 */
#ifndef PL_BASE_PRINTF_H
#define PL_BASE_PRINTF_H

#if defined(__MINGW32__) /* its own printf was another; planish is built with that of C99 */
#define PL_PRINTF(text, first) __attribute__((format(gnu_printf, text, first)))
#elif defined(__GNUC__)
#define PL_PRINTF(text, first) __attribute__((format(printf, text, first)))
#else
#define PL_PRINTF(text, first)
#endif

#endif
