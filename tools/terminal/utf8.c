/* utf8: what is text. */
#include "terminal/utf8.h"

int pl_utf8_length(const char *text) {
    const unsigned char *byte = (const unsigned char *)text;
    const unsigned char lead = byte[0];
    const int length = lead < 0x80 ? 1 : lead < 0xC2 ? 0 : lead < 0xE0 ? 2 : lead < 0xF0 ? 3 : 4;
    if (lead > 0xF4)
        return 0;
    for (int i = 1; i < length; i++)
        if ((byte[i] & 0xC0) != 0x80)
            return 0;
    if (length < 3)
        return length;
    const int overlong = (lead == 0xE0 && byte[1] < 0xA0) || (lead == 0xF0 && byte[1] < 0x90);
    const int no_character = (lead == 0xED && byte[1] > 0x9F) || (lead == 0xF4 && byte[1] > 0x8F);
    return overlong || no_character ? 0 : length;
}
